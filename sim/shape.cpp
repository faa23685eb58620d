#include "sim/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Vec3d unit(const Vec3d& x) { const double n = x.norm(); return n > 0 ? Vec3d(x / n) : Vec3d(0, 1, 0); }

/// A point as a cylinder sees it: height above its middle along the axis, and distance from the axis.
struct Cylindrical {
    Vec3d axis, radial;     ///< unit vectors
    double half_length, height, distance;
    Cylindrical(const Vec3d& from, const Vec3d& to, const Vec3d& x)
        : axis(unit(to - from)), half_length((to - from).norm() / 2) {
        const Vec3d r = x - (from + to) / 2;
        height = r.dot(axis);
        const Vec3d across = r - height * axis;
        distance = across.norm();
        radial = distance > 0 ? Vec3d(across / distance) : axis.unitOrthogonal();
    }
};

double distance(const Plane& s, const Vec3d& x) { return (x - s.point).dot(unit(s.normal)); }
double distance(const Sphere& s, const Vec3d& x) { return (x - s.center).norm() - s.radius; }
double distance(const Box& s, const Vec3d& x) {
    const Vec3d q = (x - s.center).cwiseAbs() - s.size / 2;
    return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}
double distance(const Cylinder& s, const Vec3d& x) {
    const Cylindrical c(s.from, s.to, x);
    const Eigen::Vector2d q(c.distance - s.radius, std::abs(c.height) - c.half_length);
    return q.cwiseMax(0).norm() + std::min(q.maxCoeff(), 0.0);
}
Vec3d nearest_on_segment(const Vec3d& a, const Vec3d& b, const Vec3d& x) {
    const double length2 = (b - a).squaredNorm();
    return length2 > 0 ? Vec3d(a + std::clamp((x - a).dot(b - a) / length2, 0.0, 1.0) * (b - a)) : a;
}
double distance(const Capsule& s, const Vec3d& x) { return (x - nearest_on_segment(s.from, s.to, x)).norm() - s.radius; }
double distance(const Ellipsoid& s, const Vec3d& x) {
    return ((x - s.center).cwiseQuotient(s.radii).norm() - 1) * s.radii.minCoeff();
}
double distance(const Union& s, const Vec3d& x) {
    double d = infinity;
    for (const Shape& part : s.shapes) d = std::min(d, signed_distance(part, x));
    return d;
}
double distance(const Difference& s, const Vec3d& x) {
    double d = s.shapes.empty() ? infinity : signed_distance(s.shapes[0], x);
    for (std::size_t i = 1; i < s.shapes.size(); ++i) d = std::max(d, -signed_distance(s.shapes[i], x));
    return d;
}

Vec3d normal(const Plane& s, const Vec3d&) { return unit(s.normal); }
Vec3d normal(const Sphere& s, const Vec3d& x) { return unit(x - s.center); }
Vec3d normal(const Box& s, const Vec3d& x) {
    const Vec3d r = x - s.center, q = r.cwiseAbs() - s.size / 2;
    const Vec3d side = r.unaryExpr([](double c) { return c < 0 ? -1.0 : 1.0; });
    if (q.maxCoeff() > 0) return unit(q.cwiseMax(0).cwiseProduct(side));
    int axis;
    q.maxCoeff(&axis);
    return side(axis) * Vec3d::Unit(axis);
}
Vec3d normal(const Cylinder& s, const Vec3d& x) {
    const Cylindrical c(s.from, s.to, x);
    const Vec3d end = c.height < 0 ? Vec3d(-c.axis) : c.axis;
    const double side = c.distance - s.radius, beyond = std::abs(c.height) - c.half_length;
    if (side > 0 && beyond > 0) return unit(side * c.radial + beyond * end);
    return side > beyond ? c.radial : end;
}
Vec3d normal(const Capsule& s, const Vec3d& x) {
    const Vec3d r = x - nearest_on_segment(s.from, s.to, x);
    return r.norm() > 0 ? unit(r) : unit(s.to - s.from).unitOrthogonal();
}
Vec3d normal(const Ellipsoid& s, const Vec3d& x) { return unit((x - s.center).cwiseQuotient(s.radii.cwiseAbs2())); }
Vec3d normal(const Union& s, const Vec3d& x) {
    const auto nearest = std::min_element(s.shapes.begin(), s.shapes.end(), [&](const Shape& a, const Shape& b) {
        return signed_distance(a, x) < signed_distance(b, x); });
    return nearest == s.shapes.end() ? Vec3d(0, 1, 0) : outward_normal(*nearest, x);
}
Vec3d normal(const Difference& s, const Vec3d& x) {
    const double d = distance(s, x);
    for (std::size_t i = 1; i < s.shapes.size(); ++i)
        if (-signed_distance(s.shapes[i], x) >= d) return -outward_normal(s.shapes[i], x);
    return s.shapes.empty() ? Vec3d(0, 1, 0) : outward_normal(s.shapes[0], x);
}

Bounds around(const Vec3d& center, const Vec3d& half) { return {center - half, center + half}; }
Bounds box_of(const Plane&) { return {Vec3d::Constant(-infinity), Vec3d::Constant(infinity)}; }
Bounds box_of(const Sphere& s) { return around(s.center, Vec3d::Constant(s.radius)); }
Bounds box_of(const Box& s) { return around(s.center, s.size / 2); }
Bounds box_of(const Cylinder& s) {
    // A disc with unit normal a reaches r √(1 − a_k²) along axis k.
    const Vec3d a = unit(s.to - s.from);
    const Vec3d reach = s.radius * (Vec3d::Ones() - a.cwiseAbs2()).cwiseMax(0).cwiseSqrt();
    Bounds b = around(s.from, reach);
    b.extend(around(s.to, reach));
    return b;
}
Bounds box_of(const Capsule& s) {
    Bounds b = around(s.from, Vec3d::Constant(s.radius));
    b.extend(around(s.to, Vec3d::Constant(s.radius)));
    return b;
}
Bounds box_of(const Ellipsoid& s) { return around(s.center, s.radii); }
Bounds box_of(const Union& s) {
    Bounds b;
    for (const Shape& part : s.shapes) b.extend(bounds(part));
    return b;
}
Bounds box_of(const Difference& s) { return s.shapes.empty() ? Bounds{} : bounds(s.shapes[0]); }

Nearby part_near(const Union& s, const Vec3d& x, double r) {
    Union near;
    for (const Shape& part : s.shapes) {
        Nearby of_part = nearby(part, x, r);
        if (of_part.what == Nearby::everything) return of_part;
        if (of_part.what == Nearby::some) near.shapes.push_back(std::move(of_part.shape));
    }
    if (near.shapes.empty()) return {Nearby::nothing};
    if (near.shapes.size() == 1) return {Nearby::some, Shape(near.shapes.front())};
    return {Nearby::some, std::move(near)};
}
Nearby part_near(const Difference& s, const Vec3d& x, double r) {
    if (s.shapes.empty()) return {Nearby::nothing};
    Nearby first = nearby(s.shapes.front(), x, r);
    if (first.what == Nearby::nothing) return first;
    Difference near{{first.what == Nearby::some ? first.shape : s.shapes.front()}};
    for (std::size_t i = 1; i < s.shapes.size(); ++i) {
        Nearby less = nearby(s.shapes[i], x, r);
        if (less.what == Nearby::everything) return {Nearby::nothing};
        if (less.what == Nearby::some) near.shapes.push_back(std::move(less.shape));
    }
    if (near.shapes.size() == 1) return first;
    return {Nearby::some, std::move(near)};
}
template <class Simple> Nearby part_near(const Simple& s, const Vec3d& x, double r) {
    const double d = distance(s, x);
    if (d >= r) return {Nearby::nothing};
    if (d <= -r) return {Nearby::everything};
    return {Nearby::some, s};
}

}  // namespace

double signed_distance(const Shape& shape, const Vec3d& x) {
    return std::visit([&](const auto& s) { return distance(s, x); }, shape.kind());
}
Vec3d outward_normal(const Shape& shape, const Vec3d& x) {
    return std::visit([&](const auto& s) { return normal(s, x); }, shape.kind());
}
Bounds bounds(const Shape& shape) {
    return std::visit([](const auto& s) { return box_of(s); }, shape.kind());
}
Nearby nearby(const Shape& shape, const Vec3d& x, double r) {
    return std::visit([&](const auto& s) { return part_near(s, x, r); }, shape.kind());
}

}  // namespace firn
