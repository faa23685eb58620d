#include "app/checkpoint.h"
#include "app/files.h"
#include "app/scene_particles.h"
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>

#include <sstream>

using namespace firn;

static LoadedScene small_scene() {
    return load_scene_text(
        "grid_spacing: 0.1\nbodies: [{shape: {sphere: {center: [0, 0.25, 0], radius: 0.2}}, velocity: [0, "
        "-3, 0]}]\n"
        "colliders: [{shape: {plane: {}}}]\nsolver: {integrator: explicit, weights: quadratic}\n",
        "s.yaml");
}

static std::unique_ptr<Simulation> start(const LoadedScene& loaded) {
    return make_simulation(make_setup(loaded.scene),
                           make_particles(loaded, loaded.scene.grid_spacing).particles);
}

static std::string state_of(const Simulation& simulation) {
    std::ostringstream stream;
    simulation.save(stream);
    return stream.str();
}

static Checkpoint sample_checkpoint(const LoadedScene& loaded, const Simulation& simulation) {
    Checkpoint c{program_version(),           loaded.resolved, loaded.hash, 3, 0.1 + 0.2, {}, {},
                 compressed_state(simulation)};
    c.running.add(
        {.dt = 1.0 / 3, .iterations = 5, .residuals = {1, 0.125}, .converged = true, .rejected = 0, .nodes = 17}, 0.25);
    c.frames.resize(4);
    for (int k = 0; k < 4; ++k) c.frames[k].frame = k, c.frames[k].totals.momentum = Vec3d(k, 1e-300, -0.0);
    return c;
}

TEST_CASE("A state goes through compression and back to the bit, and goes on as if nothing had been",
          "[checkpoint]") {
    const auto loaded = small_scene();
    const auto simulation = start(loaded);
    for (int i = 0; i < 20; ++i) simulation->step(1);
    const auto restored = start(loaded);
    restore_state(*restored, compressed_state(*simulation));
    CHECK((state_of(*restored) == state_of(*simulation)));
    for (int i = 0; i < 20; ++i) simulation->step(1), restored->step(1);
    CHECK((state_of(*restored) == state_of(*simulation)));
    CHECK((compressed_state(*restored) == compressed_state(*simulation)));
}

TEST_CASE("A checkpoint reads back as it was written", "[checkpoint]") {
    const TempFolder folder;
    const auto loaded = small_scene();
    const auto simulation = start(loaded);
    const Checkpoint c = sample_checkpoint(loaded, *simulation);
    write_checkpoint(folder / "c", c);
    const Checkpoint r = read_checkpoint(folder / "c");
    CHECK(r.version == c.version);
    CHECK(r.scene == c.scene);
    CHECK(r.scene_hash == c.scene_hash);
    CHECK(r.frame == 3);
    CHECK(r.inside == c.inside);
    CHECK(to_json(r.running) == to_json(c.running));
    REQUIRE(r.frames.size() == 4);
    CHECK(to_json(r.frames[2]) == to_json(c.frames[2]));
    CHECK((r.state == c.state));
}

TEST_CASE("A checkpoint with any byte changed or cut off is refused with what to do", "[checkpoint]") {
    const TempFolder folder;
    const auto loaded = small_scene();
    const auto simulation = start(loaded);
    write_checkpoint(folder / "c", sample_checkpoint(loaded, *simulation));
    const std::string whole = bytes_of_file(folder / "c");
    const auto refused = [&](const std::string& bytes) {
        folder.write("d", bytes);
        try {
            read_checkpoint(folder / "d");
            return false;
        } catch (const FileError& e) {
            return std::string(e.what()).find("d is damaged (") != std::string::npos &&
                   std::string(e.what()).find("--overwrite") != std::string::npos;
        }
    };
    CHECK_FALSE(refused(whole));
    for (std::size_t i = 0; i <= 64; ++i) {
        CAPTURE(i);
        const std::size_t at = std::min(whole.size() - 1, i * whole.size() / 64);
        CHECK(refused(whole.substr(0, at)));
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ 0x10);
        CHECK(refused(changed));
    }
    CHECK(refused(""));
    CHECK(refused("something else"));
    CHECK(refused(whole + "x"));
}

TEST_CASE("A state that is none is refused", "[checkpoint]") {
    const auto simulation = start(small_scene());
    CHECK_THROWS_AS(restore_state(*simulation, "no zstd stream"), FileError);
    CHECK_THROWS_AS(restore_state(*simulation, ""), FileError);
}
