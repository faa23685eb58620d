#include "app/scene_particles.h"
#include "tests/columns.h"

#include <catch2/catch.hpp>

using namespace firn;

// A particle's density is m/(V⁰ det F_E J_P).

TEST_CASE("no snow of the scene at the wall is packed denser than ice, and little of it squeezed denser", "[step]") {
    const LoadedScene loaded = load_scene(FIRN_SOURCE_DIR "/scenes/snowball_wall.yaml", {"draft", {}});
    const double ice = loaded.scene.materials.at("snow").max_density, limit = loaded.scene.materials.at("snow").rho / ice;
    const auto sim = make_simulation(make_setup(loaded.scene), make_particles(loaded, loaded.scene.grid_spacing).particles);
    double densest = 0, packed = 0, least = 1;
    for (const double until : {0.075, 0.08, 0.085, 0.09}) {         // while it hits the wall [s]
        while (sim->time() < until) sim->step(until - sim->time());
        const ParticleSet now = start_from(sim->rows(true));
        for (std::size_t p = 0; p < now.size(); ++p) {
            least = std::min(least, now.Jp[p]);
            packed += now.Jp[p] <= limit * (1 + 1e-6);
            densest = std::max(densest, now.m[p] / (now.V0[p] * determinant(now.Fe[p]) * now.Jp[p]));
        }
    }
    CAPTURE(packed, densest);
    CHECK(packed > 0);              // the scene comes to the limit: without one, it goes far beyond
    CHECK(least >= limit * (1 - 1e-6));
    CHECK(densest < 1.2 * ice);     // what is elastic: ice of this E and xi is far softer than real one
}
