#include "sim/collision.h"
#include "tests/random_matrices.h"

#include <catch2/catch.hpp>

using namespace firn;

namespace {

Collider ground(double friction) {
    Collider c;
    c.shape = Plane{{0, 0, 0}, {0, 2, 0}};  // any length of normal will do
    c.friction = friction;
    return c;
}
const Vec3d up(0, 1, 0);

}  // namespace

TEST_CASE("what leaves a body is left alone", "[collision]") {
    const Contact c = collide(Vec3d(3, 0.1, 0), up, ground(0.5));
    CHECK(c.v == Vec3d(3, 0.1, 0));
    CHECK(c.fixes == Contact::Fixes::nothing);
}

TEST_CASE("inside the friction cone a point sticks to the body", "[collision]") {
    Collider c = ground(0.5);
    c.velocity = {1, 0, 0};
    const Contact stuck = collide(Vec3d(1.4, -1, 0), up, c);
    CHECK(stuck.v == c.velocity);
    CHECK(stuck.fixes == Contact::Fixes::everything);
}

TEST_CASE("outside it slides, slowed by mu times the normal change", "[collision]") {
    const Contact c = collide(Vec3d(3, -2, 4), up, ground(0.5));
    CHECK((c.v - Vec3d(3, 0, 4) * (1 - 0.5 * 2 / 5)).norm() < 1e-15);
    CHECK(c.fixes == Contact::Fixes::normal);
}

TEST_CASE("a sticky body takes along whatever is inside, leaving or not", "[collision]") {
    Collider c = ground(0);
    c.contact = ContactLaw::sticky;
    c.velocity = {0, 0, 7};
    CHECK(collide(Vec3d(1, 5, 0), up, c).v == c.velocity);
}

TEST_CASE("only what is inside collides, and a body moves with its velocity", "[collision]") {
    Collider c;
    c.shape = Sphere{{0, 0, 0}, 1};
    c.velocity = {2, 0, 0};
    const Vec3d v(-1, 0, 0);
    CHECK_FALSE(collide(Vec3d(2.5, 0, 0), v, {c}, 0).touched);
    CHECK(collide(Vec3d(2.5, 0, 0), v, {c}, 1).touched);
}

TEST_CASE("two frictionless walls leave only their common direction free", "[collision]") {
    Collider floor = ground(0), wall = ground(0);
    wall.shape = Plane{{0, 0, 0}, {1, 0, 0}};
    const Collided c = collide(Vec3d(-0.1, -0.1, 0), Vec3d(-1, -2, 3), {floor, wall}, 0);
    CHECK((c.v - Vec3d(0, 0, 3)).norm() < 1e-15);
    CHECK((c.free - Mat3d(Vec3d(0, 0, 1).asDiagonal())).norm() < 1e-15);
}

TEST_CASE("contact never adds energy in the body's frame", "[collision]") {
    RandomInput random;
    for (int n = 0; n < 1000; ++n) {
        Collider c = ground(std::abs(random.number()));
        c.velocity = random.vector();
        const Vec3d v = 5 * random.vector(), normal = random.vector().normalized();
        REQUIRE((collide(v, normal, c).v - c.velocity).norm() <= (v - c.velocity).norm() * (1 + 1e-12));
        REQUIRE((collide(v, normal, c).v - c.velocity).dot(normal) >= -1e-12);
    }
}

TEST_CASE("elastic contact lets FLIP see nothing of a node's way into the body", "[collision]") {
    const Collider floor = ground(0.5);
    // Along the normal nothing is left; FLIP sees v − before: nothing along it, 0.5 · 0.2 of friction, and the push along x.
    const NodeCollided c = collide_elastic(Vec3d(0, -1, 0), {Vec3d(3, -2, 0), Vec3d(3.1, -2.2, 0), Vec3d(0.1, -0.2, 0)}, {floor}, 0);
    CHECK((c.v - Vec3d(3.1 - 0.1, 0, 0)).norm() < 1e-14);
    CHECK((c.before - Vec3d(3, 0, 0)).norm() < 1e-14);
    // A node that leaves is free, unless stresses still press it on.
    CHECK_FALSE(collide_elastic(Vec3d(0, -1, 0), {Vec3d(0, 1, 0), Vec3d(0, 0.9, 0)}, {floor}, 0).touched);
    CHECK(collide_elastic(Vec3d(0, -1, 0), {Vec3d(0, 1, 0), Vec3d(0, 0.9, 0), Vec3d(0, -0.1, 0)}, {floor}, 0).v.norm() == 0);
}

TEST_CASE("elastic contact takes from stresses and particles together no less than nothing", "[collision]") {
    RandomInput random;
    for (int n = 0; n < 1000; ++n) {
        Collider c = ground(std::abs(random.number()));
        if (n % 4 == 0) c.contact = ContactLaw::sticky;
        c.velocity = random.vector();
        const Vec3d v = random.vector(), d = random.vector();
        const NodeCollided r = collide_elastic(Vec3d(0, -1, 0), {v, v + d, d}, {c}, 0);
        // Power in the body's frame: of the particles, which see v − before, less the stresses' own.
        REQUIRE((v - c.velocity).dot(r.v - r.before) - d.dot(r.v - c.velocity) < 1e-12);
    }
}
