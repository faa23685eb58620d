#include "render/meshes.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace firn {

namespace {

constexpr int sides = 96;  ///< around an axis: the outline of a sphere 1000 pixels high is 0.3 pixels off.
constexpr double pi = std::numbers::pi;

/// A point of an outline that turns about an axis.
struct OutlinePoint {
    double radius, height;                ///< [m]
    double normal_radius, normal_height;  ///< unit
};

void add_triangle(std::vector<Vertex>& mesh, const Vertex& a, const Vertex& b, const Vertex& c) {
    mesh.insert(mesh.end(), {a, b, c});
}

/// The surface between neighbouring points of the outline, about the axis through `base`.
std::vector<Vertex> revolved(const std::vector<OutlinePoint>& outline, const Vec3d& base, const Vec3d& axis) {
    const Vec3d e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
    const auto vertex = [&](const OutlinePoint& p, int side) {
        const double angle = 2 * pi * side / sides;
        const Vec3d out = std::cos(angle) * e1 + std::sin(angle) * e2;
        return Vertex{(base + p.radius * out + p.height * axis).cast<float>(),
                      (p.normal_radius * out + p.normal_height * axis).cast<float>()};
    };
    std::vector<Vertex> mesh;
    for (std::size_t k = 0; k + 1 < outline.size(); ++k)
        for (int side = 0; side < sides; ++side) {
            const Vertex a = vertex(outline[k], side), b = vertex(outline[k], side + 1);
            const Vertex c = vertex(outline[k + 1], side), d = vertex(outline[k + 1], side + 1);
            add_triangle(mesh, a, b, c);
            add_triangle(mesh, b, d, c);
        }
    return mesh;
}

/// An arc about (0, height), from below (angle −π/2) to above (π/2).
void add_arc(std::vector<OutlinePoint>& outline, double radius, double height, double from, double to) {
    constexpr int steps = sides / 2;
    for (int k = 0; k <= steps; ++k) {
        const double angle = from + (to - from) * k / steps;
        outline.push_back(
            {radius * std::cos(angle), height + radius * std::sin(angle), std::cos(angle), std::sin(angle)});
    }
}

Vec3d direction(const Vec3d& from, const Vec3d& to) {
    const double length = (to - from).norm();
    return length > 0 ? Vec3d((to - from) / length) : Vec3d(0, 1, 0);
}

std::vector<Vertex> mesh_of(const Plane&) { return {}; }

std::vector<Vertex> mesh_of(const Sphere& s) {
    std::vector<OutlinePoint> outline;
    add_arc(outline, s.radius, 0, -pi / 2, pi / 2);
    return revolved(outline, s.center, {0, 1, 0});
}

std::vector<Vertex> mesh_of(const Capsule& c) {
    std::vector<OutlinePoint> outline;
    add_arc(outline, c.radius, 0, -pi / 2, 0);
    add_arc(outline, c.radius, (c.to - c.from).norm(), 0, pi / 2);
    return revolved(outline, c.from, direction(c.from, c.to));
}

std::vector<Vertex> mesh_of(const Cylinder& c) {
    const double length = (c.to - c.from).norm(), r = c.radius;
    // Each edge stands twice, once with the normal of either side; the surface between the two has no area.
    const std::vector<OutlinePoint> outline = {{0, 0, 0, -1},     {r, 0, 0, -1},     {r, 0, 1, 0},
                                               {r, length, 1, 0}, {r, length, 0, 1}, {0, length, 0, 1}};
    return revolved(outline, c.from, direction(c.from, c.to));
}

std::vector<Vertex> mesh_of(const Box& b) {
    std::vector<Vertex> mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            const Vec3d normal = sign * Vec3d::Unit(axis);
            const Vec3d u = Vec3d::Unit((axis + 1) % 3), v = normal.cross(u);
            const auto corner = [&](double a, double c) {
                const Vec3d x = b.center + 0.5 * b.size.cwiseProduct(normal + a * u + c * v);
                return Vertex{x.cast<float>(), normal.cast<float>()};
            };
            add_triangle(mesh, corner(-1, -1), corner(1, -1), corner(1, 1));
            add_triangle(mesh, corner(-1, -1), corner(1, 1), corner(-1, 1));
        }
    return mesh;
}

template <class Other>
std::vector<Vertex> mesh_of(const Other&) {
    throw std::invalid_argument("a collider is a plane, sphere, box, cylinder or capsule");
}

}  // namespace

std::vector<Vertex> triangles_of(const Collider& collider, double time) {
    std::vector<Vertex> mesh =
        std::visit([](const auto& shape) { return mesh_of(shape); }, collider.shape.kind());
    const Eigen::Vector3f moved = (time * collider.velocity).cast<float>();
    for (Vertex& vertex : mesh) vertex.position += moved;
    return mesh;
}

}  // namespace firn
