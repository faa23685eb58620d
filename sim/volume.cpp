#include "sim/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

// Compiled as sampling.cpp is: the same volume on every machine.

namespace firn {
namespace {

constexpr double pi = std::numbers::pi;

/// The share of the cube |y_a| ≤ s in which g·y + φ < 0, the plane's side below: with m_a = |g_a|, α = (s Σ m − φ)/(2s),
///   Σ_S (−1)^|S| max(0, α − Σ_{a∈S} m_a)³ / (6 m_x m_y m_z)   over the subsets S of the axes.
double share_below(const Vec3d& g, double phi, double s) {
    const Vec3d m = g.cwiseAbs().cwiseMax(1e-4 * g.cwiseAbs().maxCoeff());     // a plane along an axis would divide by 0
    const double alpha = (s * m.sum() - phi) / (2 * s);
    double sum = 0;
    for (int subset = 0; subset < 8; ++subset) {
        double left = alpha, sign = 1;
        for (int a = 0; a < 3; ++a)
            if (subset >> a & 1) left -= m(a), sign = -sign;
        if (left > 0) sum += sign * left * left * left;
    }
    return std::clamp(sum / (6 * m.prod()), 0.0, 1.0);
}

/// Whether φ changes its sign where it becomes 0 when one goes from x along or against the gradient. Where parts touch
/// within a union, or what is taken away ends with the rest, it does not, and there is no surface.
bool meets_surface(const Shape& shape, const Vec3d& x, double phi, const Vec3d& gradient, double beyond) {
    if (!std::holds_alternative<Union>(shape.kind()) && !std::holds_alternative<Difference>(shape.kind())) return true;
    const double slope = gradient.norm();
    Vec3d y = x;
    double left = phi;
    for (int newton = 0; newton < 3; ++newton) y -= left / (slope * slope) * gradient, left = signed_distance(shape, y);
    return phi * signed_distance(shape, y - (phi < 0 ? -beyond : beyond) / slope * gradient) <= 0;
}

/// The share of the cube with half the edge s that is inside, the surface taken as a plane there.
double share_inside(const Shape& shape, const Vec3d& center, double s) {
    const double e = s / 8, phi = signed_distance(shape, center);
    Vec3d gradient;
    for (int a = 0; a < 3; ++a)
        gradient(a) = (signed_distance(shape, center + e * Vec3d::Unit(a)) - signed_distance(shape, center - e * Vec3d::Unit(a))) / (2 * e);
    if (!(gradient.norm() > 0) || !meets_surface(shape, center, phi, gradient, 1e-4 * s)) return phi < 0 ? 1 : 0;
    return share_below(gradient, phi, s);
}

/// Cubes through which the surface goes are halved until half their edge is `least` or less; counts those.
double volume_in_cube(const Shape& shape, const Vec3d& center, double s, double least, long& cut) {
    const Nearby near = nearby(shape, center, std::sqrt(3.0) * s);
    if (near.what == Nearby::nothing) return 0;
    if (near.what == Nearby::everything) return 8 * s * s * s;
    if (s <= least) return ++cut, 8 * s * s * s * share_inside(near.shape, center, s);
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d side(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        sum += volume_in_cube(near.shape, center + s / 2 * side, s / 2, least, cut);
    }
    return sum;
}

/// Smaller cubes until the sum stands still (its error goes with s², so the change before was four times as large), or there
/// are so many that nothing thin can matter.
double volume_by_cubes(const Shape& shape, double resolution) {
    constexpr double settled = 2e-4, finest = 1.0 / 64;
    constexpr long most = 500'000;
    const Bounds b = bounds(shape);
    if (b.empty()) return 0;
    const double s = (b.upper - b.lower).maxCoeff() / 2;
    double now = 0, change = 1e300, least = s / 32;
    for (long cut = 0; cut <= most && least >= std::min(finest * resolution, s / 128); least /= 2) {
        const double before = now, change_before = change;
        cut = 0;
        now = volume_in_cube(shape, (b.lower + b.upper) / 2, s, least, cut);
        change = std::abs(now - before);
        if (least <= resolution / 4 && change <= settled * now && change_before <= 5 * settled * now) break;
    }
    return now;
}

double volume_of(const Plane&, double) { return std::numeric_limits<double>::infinity(); }
double volume_of(const Sphere& s, double) { return 4 * pi / 3 * s.radius * s.radius * s.radius; }
double volume_of(const Box& s, double) { return s.size.prod(); }
double volume_of(const Cylinder& s, double) { return pi * s.radius * s.radius * (s.to - s.from).norm(); }
double volume_of(const Capsule& s, double) { return pi * s.radius * s.radius * ((s.to - s.from).norm() + 4 * s.radius / 3); }
double volume_of(const Ellipsoid& s, double) { return 4 * pi / 3 * s.radii.prod(); }
template <class Compound> double volume_of(const Compound& s, double resolution) { return volume_by_cubes(s, resolution); }

}  // namespace

double volume(const Shape& shape, double resolution) {
    return std::visit([&](const auto& s) { return volume_of(s, resolution); }, shape.kind());
}

}  // namespace firn
