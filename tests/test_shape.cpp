#include "sim/shape.h"
#include "tests/random_matrices.h"

#include <catch2/catch.hpp>


using namespace firn;

namespace {

const Shape exact[] = {Plane{{0.1, 0.2, 0}, {1, 3, -1}}, Sphere{{0.2, 0, -0.1}, 0.7}, Box{{0, 0.3, 0}, {1, 2, 0.6}},
                       Cylinder{{0, -0.5, 0.2}, {0.3, 0.9, 0}, 0.5}, Capsule{{0, -0.5, 0.2}, {0.3, 0.9, 0}, 0.4}};

}  // namespace

TEST_CASE("following the normal leads to the surface, at the signed distance", "[shape]") {
    RandomInput random;
    for (const Shape& s : exact)
        for (int n = 0; n < 2000; ++n) {
            const Vec3d x = random.vector();
            const double d = signed_distance(s, x);
            const Vec3d normal = outward_normal(s, x);
            CAPTURE(s.index(), x, d, normal);
            REQUIRE(normal.norm() == Approx(1));
            REQUIRE(signed_distance(s, x - d * normal) == Approx(0).margin(1e-9));
            // Nothing nearer: a distance changes by no more than one moves.
            const Vec3d y = x + 0.1 * random.vector();
            REQUIRE(std::abs(signed_distance(s, y) - d) <= (y - x).norm() + 1e-12);
        }
}

TEST_CASE("bounds hold the shape and volumes are those of the inside", "[shape]") {
    RandomInput random;
    const Shape shapes[] = {exact[1], exact[2], exact[3], exact[4], Ellipsoid{{0, 0.1, 0}, {0.4, 0.8, 0.6}},
                            Union{{Shape(Sphere{{0, 0, 0}, 0.5}), Shape(Box{{0.6, 0, 0}, {0.8, 0.4, 0.4}})}},
                            Difference{{Shape(Sphere{{0, 0, 0}, 0.9}), Shape(Plane{{0, 0.1, 0}, {0, 1, 0}})}}};
    for (const Shape& s : shapes) {
        const Bounds b = bounds(s);
        const int n = 200000;
        int inside = 0, beyond = 0;
        for (int i = 0; i < n; ++i) {
            const Vec3d u((random.bits() >> 11) * 0x1p-53, (random.bits() >> 11) * 0x1p-53, (random.bits() >> 11) * 0x1p-53);
            const Vec3d x = b.lower + (b.upper - b.lower).cwiseProduct(u);
            inside += signed_distance(s, x) < 0;
            const Vec3d far = 1.5 * random.vector();
            beyond += signed_distance(s, far) < 0 && ((far - b.lower).minCoeff() < 0 || (b.upper - far).minCoeff() < 0);
        }
        CAPTURE(s.index());
        CHECK(beyond == 0);
        CHECK(volume(s, 0.05) == Approx(inside * (b.upper - b.lower).prod() / n).epsilon(0.01));
    }
}

TEST_CASE("an empty union has no inside", "[shape]") {
    CHECK(bounds(Shape(Union{})).empty());
    CHECK(signed_distance(Shape(Union{}), Vec3d::Zero()) > 0);
}

// Unions and differences whose volumes are known.
TEST_CASE("volumes of compound shapes are right to a thousandth", "[shape]") {
    constexpr double pi = std::numbers::pi;
    RandomInput random;
    const auto between = [&](double a, double b) { return a + (b - a) * (random.bits() >> 11) * 0x1p-53; };
    const auto hollow = [](const Vec3d& at, const Vec3d& size, double wall) {
        return Shape(Difference{{Shape(Box{at, size}), Shape(Box{at, size - Vec3d::Constant(2 * wall)})}});
    };
    const auto box_volume = [](const Vec3d& size, double wall) { return size.prod() - (size - Vec3d::Constant(2 * wall)).prod(); };
    const double spacing = 0.02;
    const auto check = [&](const Shape& shape, double exact) {
        CAPTURE(exact, volume(shape, spacing) / exact - 1);
        CHECK(volume(shape, spacing) == Approx(exact).epsilon(1e-3));
    };
    for (int i = 0; i < 2; ++i) {
        const Vec3d at = random.vector(), size(between(0.5, 2), between(0.5, 2), between(0.5, 2));
        for (const double wall : {0.1, 0.03, 0.02}) check(hollow(at, size, wall), box_volume(size, wall));
        const double R = between(0.3, 1), t = between(0.02, 0.05);
        check(Difference{{Shape(Sphere{at, R}), Shape(Sphere{at, R - t})}}, 4 * pi / 3 * (R * R * R - (R - t) * (R - t) * (R - t)));
        const Vec3d to = at + random.vector();     // a pipe
        check(Difference{{Shape(Cylinder{at, to, R}), Shape(Cylinder{at - (to - at), to + (to - at), R - t})}},
              pi * (R * R - (R - t) * (R - t)) * (to - at).norm());
        const double x = between(-0.9, 0.9) * R;    // a cap of height R − x
        check(Difference{{Shape(Sphere{at, R}), Shape(Plane{at + x * Vec3d(0, 1, 0), {0, 1, 0}})}},
              pi * (R - x) * (R - x) * (2 * R + x) / 3);
        check(Difference{{Shape(Ellipsoid{at, size}), Shape(Plane{at, random.vector()})}}, 2 * pi / 3 * size.prod());
    }
    for (const double apart : {2.0, 20.0, 1e4}) {
        const Vec3d far = apart * Vec3d(1, 1, 1).normalized();
        check(Union{{Shape(Sphere{{0, 0, 0}, 0.5}), Shape(Sphere{far, 0.3})}}, 4 * pi / 3 * (0.125 + 0.027));
    }
    check(Union{{Shape(Box{{0, 0, 0}, {2, 0.01, 2}}), Shape(Box{{0, 1, 0}, {2, 0.01, 2}})}}, 0.08);
    Union bricks;                                   // 343 of them, which touch
    for (int i = 0; i < 343; ++i) bricks.shapes.push_back(Box{0.1 * Vec3d(i % 7, i / 7 % 7, i / 49), {0.1, 0.1, 0.1}});
    check(bricks, 0.343);
}
