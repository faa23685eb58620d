#include "app/scene_particles.h"
#include "tests/columns.h"

#include <catch2/catch.hpp>
#include <fmt/format.h>

using namespace firn;

// A particle's density is m/(V⁰ det F_E J_P).

namespace {

/// What came together while the ball of the scene at the wall hits it, thrown `faster` times as fast.
struct Packed { double least_Jp = 1, densest = 0, at_limit = 0, ice, limit, theta_c; };

Packed packed_at_the_wall(int faster) {
    const std::string velocity = fmt::format("bodies.0.velocity=[{},1.2,0]", 8 * faster);
    const LoadedScene loaded = load_scene(FIRN_SOURCE_DIR "/scenes/snowball_wall.yaml", {"draft", {velocity}});
    const Snow& snow = loaded.scene.materials.at("snow");
    Packed r{.ice = snow.max_density, .limit = snow.rho / snow.max_density, .theta_c = snow.theta_c};
    const auto sim = make_simulation(make_setup(loaded.scene), make_particles(loaded, loaded.scene.grid_spacing).particles);
    for (const double until : {0.075 / faster, 0.08 / faster, 0.085 / faster, 0.09 / faster}) {         // [s]
        while (sim->time() < until) sim->step(until - sim->time());
        const ParticleSet now = start_from(sim->rows(true));
        for (std::size_t p = 0; p < now.size(); ++p) {
            r.least_Jp = std::min(r.least_Jp, now.Jp[p]);
            r.at_limit += now.Jp[p] <= r.limit * (1 + 1e-6);
            r.densest = std::max(r.densest, now.m[p] / (now.V0[p] * determinant(now.Fe[p]) * now.Jp[p]));
        }
    }
    return r;
}

}  // namespace

TEST_CASE("no snow of the scene at the wall is denser than ice that is squeezed by theta_c", "[step]") {
    const Packed r = packed_at_the_wall(1);
    CHECK(r.least_Jp >= r.limit * (1 - 1e-6));
    CHECK(r.densest < r.ice / (1 - r.theta_c));
}

TEST_CASE("no snow that hits a wall at 16 m/s is packed denser than ice, and little of it squeezed denser", "[step]") {
    const Packed r = packed_at_the_wall(2);
    CAPTURE(r.densest);
    CHECK(r.at_limit > 0);              // without a limit it goes far beyond
    CHECK(r.least_Jp >= r.limit * (1 - 1e-6));
    CHECK(r.densest < 1.3 * r.ice);     // what is elastic: ice of this E and xi is far softer than real one
}
