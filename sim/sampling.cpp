#include "sim/sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

// Compiled without contraction of a·b + c (see CMakeLists.txt) and without library functions whose last bit may
// differ: the same seed gives the same particles on every machine.

namespace firn {
namespace {

using Random = std::mt19937_64;

/// [0, 1), 53 bits. (std::uniform_real_distribution may differ between libraries.)
double uniform(Random& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }
Vec3d uniform_point(Random& random) {
    const double x = uniform(random), y = uniform(random), z = uniform(random);
    return {x, y, z};
}

/// ∛a for a > 0 by Newton's method, to the last bit or two.
double cube_root(double a) {
    double y = 1;
    while (y * y * y < a) y *= 2;
    for (int i = 0; i < 200; ++i) {
        const double next = (2 * y + a / (y * y)) / 3;
        if (next >= y && i > 0) break;
        y = next;
    }
    return y;
}

/// A unit cube of points that repeats seamlessly, no two nearer than a radius, found by throwing darts and
/// lowering the radius whenever no place is left (relaxation dart throwing, McCool and Fiume 1992).
std::vector<Vec3d> poisson_tile(int count, Random& random) {
    double radius = cube_root(1.0 / count);
    const int cells = std::max(1, static_cast<int>(1 / radius));
    const auto cell = [&](double c) { return std::min(static_cast<int>(c * cells), cells - 1); };
    const auto number = [&](int i, int j, int k) { return (std::size_t(i) * cells + j) * cells + k; };
    std::vector<std::vector<Vec3d>> at(number(cells, 0, 0));
    const auto within_radius = [&](const Vec3d& x, const std::vector<Vec3d>& others) {
        for (const Vec3d& y : others) {
            Vec3d r = (x - y).cwiseAbs();
            r = r.cwiseMin(Vec3d::Ones() - r);          // the nearest of its repetitions
            if (r.squaredNorm() < radius * radius) return true;
        }
        return false;
    };
    const auto crowded = [&](const Vec3d& x) {
        std::array<std::array<int, 3>, 3> near;         // its own cell first: most darts that miss are told there
        for (int a = 0; a < 3; ++a) {
            const int c = cell(x(a));
            near[a] = {c, c == 0 ? cells - 1 : c - 1, c == cells - 1 ? 0 : c + 1};
        }
        for (const int i : near[0])
            for (const int j : near[1])
                for (const int k : near[2])
                    if (within_radius(x, at[number(i, j, k)])) return true;
        return false;
    };
    std::vector<Vec3d> points;
    for (int failures = 0; static_cast<int>(points.size()) < count;) {
        const Vec3d x = uniform_point(random);
        if (crowded(x)) {
            if (++failures == 1500) failures = 0, radius *= 0.985;
            continue;
        }
        failures = 0;
        points.push_back(x);
        at[number(cell(x.x()), cell(x.y()), cell(x.z()))].push_back(x);
    }
    return points;
}

/// Calls f(cell) for those cells of that width, by their indices, that the shape comes near, in the order of their indices
/// along x, then y, then z, as long as f returns true. `first` and `count`: the box of cells.
template <class F> bool for_each_cell(const Shape& shape, double width, const Vec3d& first, const Vec3d& count, F&& f) {
    const Nearby near = nearby(shape, width * (first + count / 2), width * count.norm() / 2 * (1 + 1e-9));
    if (near.what == Nearby::nothing) return true;
    const int axis = count(0) > 1 ? 0 : count(1) > 1 ? 1 : 2;
    if (count(axis) <= 1) return f(first);
    const double half = std::floor(count(axis) / 2);
    Vec3d second = first, lower = count, upper = count;
    second(axis) += half, lower(axis) = half, upper(axis) -= half;
    const Shape& rest = near.what == Nearby::some ? near.shape : shape;
    return for_each_cell(rest, width, first, lower, f) && for_each_cell(rest, width, second, upper, f);
}
template <class F> void for_each_cell(const Shape& shape, double width, F&& f) {
    const Bounds b = bounds(shape);
    if (b.empty()) return;
    const Vec3d first = (b.lower / width).array().floor(), last = (b.upper / width).array().floor();
    for_each_cell(shape, width, first, last - first + Vec3d::Ones(), f);
}

constexpr int tile_points = 4000;           // a tile is about 8 cells of the grid wide at 8 particles a cell

/// Width of the cells [m] in which points are tried.
double cell_width(const Body& body, double h) {
    const double spacing = h / cube_root(body.particles_per_cell);
    return spacing * (body.sampling == Sampling::poisson_disk ? cube_root(tile_points) : body.sampling == Sampling::lattice ? 1 : 4);
}

std::vector<Vec3d> points_in(const Body& body, double h, Random& random) {
    std::vector<Vec3d> points;
    const double width = cell_width(body, h);
    const auto keep = [&](const Vec3d& x) { if (signed_distance(body.shape, x) < 0) points.push_back(x); };
    switch (body.sampling) {
    case Sampling::poisson_disk: {
        const std::vector<Vec3d> tile = poisson_tile(tile_points, random);
        for_each_cell(body.shape, width, [&](const Vec3d& c) { for (const Vec3d& x : tile) keep(width * (c + x)); return true; });
        break;
    }
    case Sampling::lattice:
        for_each_cell(body.shape, width, [&](const Vec3d& c) { return keep(width * (c + Vec3d::Constant(0.5))), true; });
        break;
    case Sampling::random: {
        std::vector<Vec3d> cells;
        for_each_cell(body.shape, width, [&](const Vec3d& c) { return cells.push_back(c), true; });
        const auto count = static_cast<std::size_t>(expected_count(body, h) + 0.5);
        for (std::size_t tries = 0; points.size() < count && tries < 1000 * count && !cells.empty(); ++tries) {
            const auto cell = static_cast<std::size_t>(uniform(random) * static_cast<double>(cells.size()));
            keep(width * (cells[cell] + uniform_point(random)));
        }
        break;
    }
    }
    return points;
}

}  // namespace

void ParticleSet::append(const ParticleSet& s) {
    const auto add = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    add(x, s.x), add(v, s.v), add(m, s.m), add(V0, s.V0), add(Jp, s.Jp), add(Fe, s.Fe), add(material, s.material);
}

double tries(const Body& body, double h, double most) {
    const double points = body.sampling == Sampling::poisson_disk ? tile_points : 1;
    double all = 0;
    for_each_cell(body.shape, cell_width(body, h), [&](const Vec3d&) { return (all += points) < most; });
    return all;
}

double expected_count(const Body& body, double h) {
    return volume(body.shape, h / cube_root(body.particles_per_cell)) / (h * h * h) * body.particles_per_cell;
}

ParticleSet sample(const Body& body, double rho, double h, std::uint64_t seed, std::uint8_t material) {
    Random random(seed);
    ParticleSet s;
    s.x = points_in(body, h, random);
    const std::size_t n = s.x.size();
    Vec3d center = Vec3d::Zero();
    for (const Vec3d& x : s.x) center += x / static_cast<double>(n);
    for (const Vec3d& x : s.x) s.v.push_back(body.velocity + body.angular_velocity.cross(x - center));
    s.m.assign(n, n == 0 ? 0 : rho * volume(body.shape, h / cube_root(body.particles_per_cell)) / static_cast<double>(n));
    s.V0.assign(n, 0);
    s.Jp.assign(n, 1);
    s.Fe.assign(n, Mat3d::Identity());
    s.material.assign(n, material);
    return s;
}

}  // namespace firn
