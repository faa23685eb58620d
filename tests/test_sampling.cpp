#include "sim/sampling.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace firn;

namespace {

Body ball(Sampling sampling) {
    Body b;
    b.shape = Sphere{{0.3, 0.1, -0.2}, 0.5};
    b.sampling = sampling;
    return b;
}

double nearest_pair(const ParticleSet& s) {
    std::vector<Vec3d> x = s.x;
    std::sort(x.begin(), x.end(), [](const Vec3d& a, const Vec3d& b) { return a.x() < b.x(); });
    double d = 1e300;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = i + 1; j < x.size() && x[j].x() - x[i].x() < d; ++j) d = std::min(d, (x[j] - x[i]).norm());
    return d;
}

}  // namespace

TEST_CASE("every way of sampling fills the shape with its mass and number", "[sampling]") {
    const auto sampling = GENERATE(Sampling::poisson_disk, Sampling::lattice, Sampling::random);
    const Body b = ball(sampling);
    const ParticleSet s = sample(b, 400, 0.06, 1, 3);
    double mass = 0;
    Vec3d center = Vec3d::Zero();
    for (std::size_t p = 0; p < s.size(); ++p) {
        REQUIRE(signed_distance(b.shape, s.x[p]) < 0);
        REQUIRE(s.material[p] == 3);
        mass += s.m[p];
        center += s.x[p] / s.size();
    }
    CHECK(mass == Approx(400 * volume(b.shape, 0.03)).epsilon(1e-10));
    CHECK(s.size() == Approx(expected_count(b, 0.06)).epsilon(0.01));
    CHECK((center - Vec3d(0.3, 0.1, -0.2)).norm() < 0.01);
}

TEST_CASE("Poisson-disk particles keep their distance, random ones do not", "[sampling]") {
    const double h = 0.06, mean = h / 2;
    CHECK(nearest_pair(sample(ball(Sampling::poisson_disk), 400, h, 1, 0)) > 0.75 * mean);
    CHECK(nearest_pair(sample(ball(Sampling::random), 400, h, 1, 0)) < 0.3 * mean);
    CHECK(nearest_pair(sample(ball(Sampling::lattice), 400, h, 1, 0)) == Approx(mean));
}

TEST_CASE("the seed decides, on every machine", "[sampling]") {
    const Body b = ball(Sampling::poisson_disk);
    CHECK(sample(b, 400, 0.06, 1, 0).x == sample(b, 400, 0.06, 1, 0).x);
    CHECK(sample(b, 400, 0.06, 1, 0).x != sample(b, 400, 0.06, 2, 0).x);
    // The sums of all bits, as every machine must find them.
    std::uint64_t hash = 14695981039346656037u;
    for (const Vec3d& x : sample(b, 400, 0.06, 5, 0).x)
        for (int a = 0; a < 3; ++a) hash = (hash ^ static_cast<std::uint64_t>(std::llround(std::ldexp(x(a), 50)))) * 1099511628211u;
    CHECK(hash == 8627471973728257407u);
}

TEST_CASE("angular velocity turns the body about its centre of mass", "[sampling]") {
    Body b = ball(Sampling::poisson_disk);
    b.velocity = {1, 2, 3};
    b.angular_velocity = {0, 0, 2};
    const ParticleSet s = sample(b, 400, 0.06, 1, 0);
    Vec3d momentum = Vec3d::Zero(), center = Vec3d::Zero();
    for (std::size_t p = 0; p < s.size(); ++p) momentum += s.v[p] / s.size(), center += s.x[p] / s.size();
    CHECK((momentum - b.velocity).norm() < 1e-12);
    for (std::size_t p = 0; p < s.size(); ++p) {
        const Vec3d r = s.x[p] - center;
        REQUIRE((s.v[p] - b.velocity - Vec3d(-2 * r.y(), 2 * r.x(), 0)).norm() < 1e-12);
    }
}
