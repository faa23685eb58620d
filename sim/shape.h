#pragma once
#include "sim/types.h"

#include <variant>
#include <vector>

namespace firn {

// Solids of bodies and colliders. Lengths in m, world coordinates, y up.

struct Plane { Vec3d point{0, 0, 0}, normal{0, 1, 0}; };  ///< The half space behind it; any normal ≠ 0.
struct Sphere { Vec3d center{0, 0, 0}; double radius = 1; };
struct Box { Vec3d center{0, 0, 0}, size{1, 1, 1}; };     ///< Full edge lengths, along the axes.
struct Cylinder { Vec3d from{0, 0, 0}, to{0, 1, 0}; double radius = 1; };  ///< Flat ends at from and to.
struct Capsule { Vec3d from{0, 0, 0}, to{0, 1, 0}; double radius = 1; };   ///< All within radius of the segment.
struct Ellipsoid { Vec3d center{0, 0, 0}, radii{1, 1, 1}; };

struct Shape;
struct Union { std::vector<Shape> shapes; };       ///< Everything that is in at least one of them.
struct Difference { std::vector<Shape> shapes; };  ///< The first without the others.

struct Shape : std::variant<Sphere, Plane, Box, Cylinder, Capsule, Ellipsoid, Union, Difference> {
    using variant::variant;
    const variant& kind() const { return *this; }
};

/// φ(x) [m]: below zero inside. Exact distance for plane, sphere, box, cylinder and capsule; for an
/// ellipsoid, a union or a difference only the sign is exact, and |φ| is at most the distance.
double signed_distance(const Shape&, const Vec3d& x);

/// n = ∇φ(x), of unit length; on an edge or at a centre, one of the directions that it could have.
Vec3d outward_normal(const Shape&, const Vec3d& x);

struct Bounds {
    Vec3d lower = Vec3d::Constant(1e300), upper = Vec3d::Constant(-1e300);  ///< Empty until extended.
    bool empty() const { return (lower.array() > upper.array()).any(); }
    void extend(const Vec3d& x) { lower = lower.cwiseMin(x), upper = upper.cwiseMax(x); }
    void extend(const Bounds& b) { lower = lower.cwiseMin(b.lower), upper = upper.cwiseMax(b.upper); }
};

/// The smallest box that is sure to hold the shape; infinite for a plane.
Bounds bounds(const Shape&);

/// What of a shape lies within r [m] of x: nothing, everything, or `shape`, without the parts that do not reach there.
struct Nearby {
    enum { nothing, everything, some } what;
    Shape shape{};
};
Nearby nearby(const Shape&, const Vec3d& x, double r);

/// Volume [m³]: closed forms; of a union or a difference to a thousandth (volume.cpp), unless parts are thinner than
/// `resolution` [m].
double volume(const Shape&, double resolution);

}  // namespace firn
