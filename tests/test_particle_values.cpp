#include "app/particle_values.h"
#include "app/scene_load.h"
#include "render/colour_map.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace firn;

// Two bodies, soft and hard snow.
static Scene scene_that_shows(const std::string& colour) {
    return load_scene_text(
               "grid_spacing: 0.1\nmaterials: {hard: {E: 2e6, nu: 0.25}, soft: {E: 1e5}}\nbodies:\n"
               "  - {material: soft, shape: {sphere: {radius: 0.2}}}\n"
               "  - {material: hard, shape: {sphere: {center: [1, 0, 0], radius: 0.2}}}\n"
               "picture: {colour: " +
                   colour + "}\n",
               "s.yaml")
        .scene;
}

static PlyParticles at_rest(std::size_t count) {
    PlyParticles p;
    p.x.assign(count, Vec3d::Zero()), p.v = p.x, p.Fe.assign(count, Mat3d::Identity());
    p.mass.assign(count, 3), p.volume.assign(count, 0.01), p.Jp.assign(count, 1);
    return p;
}

TEST_CASE("A colour shows what its name says", "[colour]") {
    PlyParticles p = at_rest(2);
    p.v[1] = {3, 0, -4};
    p.Jp[1] = 0.5;
    p.Fe[0] = Vec3d(1 + 1e-6, 1, 1).asDiagonal(), p.Fe[1] = 2 * Mat3d::Identity();
    const auto values = [&](const std::string& colour) {
        return particle_values(p, scene_that_shows(colour), {1, 1});
    };
    CHECK(values("snow").empty());
    CHECK(values("speed") == std::vector<double>{0, 5});
    CHECK(values("compression") == std::vector<double>{1, 0.5});
    CHECK(values("body") == std::vector<double>{0, 1});
    CHECK(values("particle-id") == std::vector<double>{0, 1});
    CHECK(values("sleeping") == std::vector<double>{0, 0});     // where nothing may sleep
    p.asleep = {0, 1};
    Scene scene = scene_that_shows("sleeping");
    scene.solver.rest_speed = 0.1;
    CHECK(particle_values(p, scene, {1, 1}) == std::vector<double>{0, 1});
    CHECK(values("density")[1] == Approx(3 / (0.01 * 8 * 0.5)));

    // Uniaxial strain ε: |σ_xx − σ_yy| = 2 μ ε, of each body's own snow.
    const double mu_soft = 1e5 / (2 * (1 + Snow{}.nu)), mu_hard = 2e6 / (2 * 1.25);
    CHECK(values("stress")[0] == Approx(2 * mu_soft * 1e-6).epsilon(1e-4));
    p.Fe[0].diagonal()[0] = 1.1;             // τ_xx − τ_yy = 2 μ (1.1 − 1) 1.1, σ = τ / 1.1
    CHECK(values("stress")[0] == Approx(0.2 * mu_soft));
    p.Fe[0].diagonal()[0] = 1 + 1e-6;
    p.Fe[1] = p.Fe[0], p.Jp[1] = 1;
    CHECK(values("stress")[1] == Approx(2 * mu_hard * 1e-6).epsilon(1e-4));
}

TEST_CASE("A colour names what the particles have not", "[colour]") {
    PlyParticles p = at_rest(1);
    p.v.clear(), p.Jp.clear(), p.mass.clear();
    const auto told = [&](const std::string& colour) { particle_values(p, scene_that_shows(colour), {1}); };
    CHECK_THROWS_WITH(told("speed"), Catch::Contains("has no velocities"));
    CHECK_THROWS_WITH(told("stress"), Catch::Contains("has no Jp"));
    p.Jp = {1};
    CHECK_THROWS_WITH(told("density"),
                      Catch::Contains("has no mass and volume") && Catch::Contains("--state full"));
}

TEST_CASE("Numbers of particles that do not fit the scene are refused where a body or its material is shown", "[colour]") {
    const PlyParticles p = at_rest(3);
    const auto bodies = [&](const std::vector<std::size_t>& counts, const char* colour = "body") {
        return particle_values(p, scene_that_shows(colour), counts);
    };
    CHECK(bodies({2, 1}) == std::vector<double>{0, 0, 1});
    const std::size_t huge = -1;
    for (const auto& counts : std::vector<std::vector<std::size_t>>{{}, {3}, {1, 1}, {2, 2}, {huge, 4}, {1, 1, 1}}) {
        CHECK_THROWS_WITH(bodies(counts), Catch::Contains("of which body") && Catch::Contains("run.json"));
        CHECK_THROWS_WITH(bodies(counts, "stress"), Catch::Contains("run.json"));
        CHECK(bodies(counts, "speed").size() == 3);
    }
    Scene one = scene_that_shows("body");
    one.bodies.resize(1);
    CHECK(particle_values(p, one, {}) == std::vector<double>(3, 0.0));
}

TEST_CASE("A colour map's ends are round and hold all but outliers, or are as given", "[colour]") {
    Picture picture;
    picture.colour = Colour::speed;
    std::vector<double> values(1000, 3.0);
    values[0] = 1e9, values[1] = std::nan("");
    CHECK(colour_range(values, picture).low == 0);
    CHECK(colour_range(values, picture).high == 5);
    picture.colour_min = -1, picture.colour_max = 4;
    CHECK(colour_range(values, picture).share(1.5) == 0.5);
    picture.colour_min = 7, picture.colour_max = {};  // beyond all values: the scale goes up, as long as it was
    CHECK(colour_range(values, picture).low == 7);
    CHECK(colour_range(values, picture).high == 12);
    picture.colour_min = {}, picture.colour_max = -2;
    CHECK(colour_range(values, picture).low == -7);
    CHECK(colour_range(values, picture).high == -2);
    picture = {}, picture.colour = Colour::compression;
    const ColourRange around = colour_range({0.93, 1.0, 1.01}, picture);
    CHECK(around.share(1) == Approx(0.5));
    CHECK(around.low == Approx(0.9));
}

TEST_CASE("compression is grey in the middle, blue where packed, red where loose; other colours get lighter",
          "[colour]") {
    const auto colour = [](double share) { return mapped_colour(Colour::compression, share); };
    const auto luma = [](const std::array<std::uint8_t, 3>& c) {
        return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
    };
    const auto middle = colour(0.5);
    CHECK(middle[0] == middle[1]);
    CHECK(middle[1] == middle[2]);
    for (const double off : {0.1, 0.3, 0.5}) {
        CAPTURE(off);
        const auto packed = colour(0.5 - off), loose = colour(0.5 + off);
        CHECK(packed[2] > packed[0] + 20);
        CHECK(loose[0] > loose[2] + 20);
        CHECK(std::max(luma(packed), luma(loose)) < luma(middle));
    }
    double before = 0;
    for (int i = 0; i <= 100; ++i) {
        CAPTURE(i);
        const double now = luma(mapped_colour(Colour::speed, 0.01 * i));
        CHECK(now >= before);
        before = now;
    }
}
