#include "render/passes.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace firn {

using Eigen::Vector3f;
using Eigen::Vector4f;

Look shown_look(const Solid& solid) {
    const Plane* plane = std::get_if<Plane>(&solid.shape.kind());
    if (solid.look == Look::glass && plane) return Look::ice;  // one can see nothing through half of space
    if (solid.look != Look::automatic) return solid.look;
    return plane && plane->normal.normalized().y() > 0.5 ? Look::snow : Look::concrete;
}

namespace {

Vector4f with(const Vec3d& x, double w) { return {float(x.x()), float(x.y()), float(x.z()), float(w)}; }

/// Of what shaders/look_*.glsl give, over snow's.
Vector3f mean_colour(Look look) {
    switch (look) {
        case Look::ice: return {0.46f, 0.49f, 0.51f};
        case Look::soil: return {0.15f, 0.11f, 0.08f};
        case Look::wood: return {0.33f, 0.21f, 0.12f};
        case Look::tiles: return {0.40f, 0.41f, 0.41f};
        case Look::concrete: return {0.36f, 0.35f, 0.34f};
        case Look::metal: return {0.33f, 0.34f, 0.35f};
        default: return Vector3f::Ones();
    }
}

/// Adds what the shape is for shaders/bodies.glsl, behind those of its kind; a sphere is a capsule of no length.
void add_distance(BodyDistances& bodies, const Shape& shape, const Vec3d& moved, const Vector3f& colour) {
    if (static_cast<int>(bodies.a.size()) == max_bodies) return;
    const auto add = [&](int& count, int after, const Vec3d& a, const Vec3d& b, double w) {
        bodies.a.insert(bodies.a.begin() + after, with(a + moved, 0));
        bodies.b.insert(bodies.b.begin() + after, with(b, w));
        bodies.colour.insert(bodies.colour.begin() + after, with(colour.cast<double>(), 0));
        ++count;
    };
    const int boxes = bodies.boxes, capsules = boxes + bodies.capsules,
              cylinders = capsules + bodies.cylinders;
    if (const auto* box = std::get_if<Box>(&shape.kind()))
        add(bodies.boxes, boxes, box->center, 0.5 * box->size, 0);
    if (const auto* s = std::get_if<Sphere>(&shape.kind()))
        add(bodies.capsules, capsules, s->center, s->center + moved, s->radius);
    if (const auto* c = std::get_if<Capsule>(&shape.kind()))
        add(bodies.capsules, capsules, c->from, c->to + moved, c->radius);
    if (const auto* c = std::get_if<Cylinder>(&shape.kind()))
        add(bodies.cylinders, cylinders, c->from, c->to + moved, c->radius);
    if (const auto* p = std::get_if<Plane>(&shape.kind()))
        add(bodies.planes, cylinders + bodies.planes, p->point, p->normal.normalized(), 0);
}

float thickness_of(const Shape& shape) {
    const auto* box = std::get_if<Box>(&shape.kind());
    return box ? static_cast<float>(box->size.minCoeff()) : 0.01f;
}

/// Axes of a body, the first along its length.
Eigen::Matrix3f lie_of(const Shape& shape) {
    Vec3d along(1, 0, 0);
    if (const auto* box = std::get_if<Box>(&shape.kind())) {
        int longest = 0;
        box->size.maxCoeff(&longest);
        along = Vec3d::Unit(longest);
    }
    if (const auto* c = std::get_if<Capsule>(&shape.kind())) along = c->to - c->from;
    if (const auto* c = std::get_if<Cylinder>(&shape.kind())) along = c->to - c->from;
    if (!(along.norm() > 0)) along = Vec3d(1, 0, 0);
    along.normalize();
    const Vec3d high = std::abs(along.y()) < 0.99 ? Vec3d(0, 1, 0) : Vec3d(1, 0, 0);
    const Vec3d across = along.cross(high).normalized();
    Eigen::Matrix3f axes;
    axes << along.cast<float>(), across.cross(along).cast<float>(), across.cast<float>();
    return axes;
}

/// A point on the axis of what is round about its length, and the radius; 0 of what is flat.
Vector4f axis_of(const Shape& shape) {
    if (const auto* s = std::get_if<Sphere>(&shape.kind())) return with(s->center, s->radius);
    if (const auto* c = std::get_if<Capsule>(&shape.kind())) return with(c->from, c->radius);
    if (const auto* c = std::get_if<Cylinder>(&shape.kind())) return with(c->from, c->radius);
    return Vector4f::Zero();
}

SolidGroup& group_of(std::vector<SolidGroup>& groups, Look look, const Vector3f& moved,
                     const Eigen::Matrix3f& lie, const Vector4f& axis) {
    for (SolidGroup& group : groups)
        if (group.look == look && group.moved == moved && group.lie == lie && group.axis == axis)
            return group;
    constexpr std::size_t most =
        250;  // the stencil buffer counts to 255; the rest share the last one's pattern
    if (groups.size() < most) groups.push_back({look, moved, lie, axis, {}, {}, 0});
    return groups.back();
}

/// The first plane that one can stand on, or none.
const Solid* ground_of(const std::vector<Solid>& solids) {
    for (const Solid& solid : solids) {
        const Plane* plane = std::get_if<Plane>(&solid.shape.kind());
        if (plane && plane->normal.normalized().y() >= 0.5) return &solid;
    }
    return nullptr;
}

}  // namespace

void Renderer::Passes::prepare_solids(Frame& frame, const std::vector<Solid>& solids, double time) {
    const Solid* ground = ground_of(solids);
    frame.ground = ground ? mean_colour(shown_look(*ground)) : Vector3f::Ones();  // else a country of snow
    frame.snow_ground = {0, 0, 0, 1e9f};
    if (ground && shown_look(*ground) == Look::snow) {
        const Plane& plane = std::get<Plane>(ground->shape.kind());
        const Vec3d n = plane.normal.normalized();
        frame.snow_ground << n.cast<float>(), static_cast<float>(-n.dot(plane.point + time * ground->velocity));
    }
    std::vector<Vertex> all, glass;
    for (const Solid& solid : solids) {
        const Vec3d moved = time * solid.velocity;
        const std::vector<Vertex> mine = triangles_of(solid, time);
        if (shown_look(solid) == Look::glass) {
            frame.glass.push_back({static_cast<GLint>(glass.size()), static_cast<GLsizei>(mine.size()),
                                   thickness_of(solid.shape)});
            glass.insert(glass.end(), mine.begin(), mine.end());
            continue;
        }
        SolidGroup& group = group_of(frame.solids, shown_look(solid), moved.cast<float>(),
                                     lie_of(solid.shape), axis_of(solid.shape));
        if (const Plane* plane = std::get_if<Plane>(&solid.shape.kind()))
            group.planes.push_back({plane->point + moved, plane->normal.normalized()});
        group.triangles.insert(group.triangles.end(), mine.begin(), mine.end());
        add_distance(frame.bodies, solid.shape, moved, 0.92f * mean_colour(shown_look(solid)));
    }
    for (SolidGroup& group : frame.solids) {
        group.first = static_cast<GLint>(all.size());
        all.insert(all.end(), group.triangles.begin(), group.triangles.end());
    }
    frame.vertices = static_cast<GLsizei>(all.size());
    for (GlassPlate& plate : frame.glass) plate.first += frame.vertices;
    all.insert(all.end(), glass.begin(), glass.end());
    upload(mesh, all.data(), all.size() * sizeof(Vertex));
}

}  // namespace firn
