#include "app/scene_load.h"

#include <catch2/catch.hpp>

using namespace firn;

static const std::string scene = R"(grid_spacing: 0.1
fps: 24
solver: {integrator: explicit, beta: 0.5}
bodies:
  - shape: {sphere: {radius: 0.2}}
  - {shape: {sphere: {center: [1, 0, 0], radius: 0.2}}, velocity: [1, 0, 0]}
presets:
  draft: {grid_spacing: 0.2, solver: {beta: 0.7}, bodies: {1: {particles_per_cell: 4}}}
  preview:
    bodies.0.particles_per_cell: 2
    bodies.0.shape: {box: {size: [1, 1, 1]}}
    solver.weights: quadratic
  final: {bodies: [{shape: {sphere: {radius: 0.3}}}]}
)";

static Scene with(const Overrides& overrides) { return load_scene_text(scene, "s.yaml", overrides).scene; }

static std::string refusal(const std::string& text, const std::string& preset = "") {
    try {
        load_scene_text(text, "s.yaml", {preset, {}});
        return "";
    } catch (const SceneError& e) {
        return e.what();
    }
}

TEST_CASE("Without a preset the scene is as written", "[preset]") {
    CHECK(with({}).grid_spacing == 0.1);
    CHECK(with({}).bodies[1].particles_per_cell == 8);
    CHECK_FALSE(load_scene_text(scene, "s.yaml").resolved.contains("presets"));
}

TEST_CASE("A preset overrides key by key, entries by index, paths by dots, and shapes by kind", "[preset]") {
    const Scene draft = with({"draft", {}});
    CHECK(draft.grid_spacing == 0.2);
    CHECK(draft.solver.beta == 0.7);
    CHECK(draft.solver.integrator == Integrator::explicit_euler);
    CHECK(draft.bodies[0].particles_per_cell == 8);
    CHECK(draft.bodies[1].particles_per_cell == 4);
    CHECK(draft.bodies[1].velocity == Vec3d(1, 0, 0));

    const Scene preview = with({"preview", {}});
    CHECK(preview.bodies[0].particles_per_cell == 2);
    CHECK(std::holds_alternative<Box>(preview.bodies[0].shape));
    CHECK(preview.solver.weights == Weights::quadratic);
    CHECK(preview.solver.beta == 0.5);

    const Scene final = with({"final", {}});
    REQUIRE(final.bodies.size() == 1);
    CHECK(std::get<Sphere>(final.bodies[0].shape).radius == 0.3);
}

TEST_CASE("option set comes after the preset, the last one wins", "[preset]") {
    const Scene set =
        with({"draft", {"solver.beta=0.8", "solver.beta=0.9", "bodies.1.particles_per_cell=16"}});
    CHECK(set.solver.beta == 0.9);
    CHECK(set.grid_spacing == 0.2);
    CHECK(set.bodies[1].particles_per_cell == 16);
}

TEST_CASE("A preset that is not there is told with those that are", "[preset]") {
    const std::string plain = "grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 0.2}}}]\n";
    CHECK(refusal(plain, "draft") == "s.yaml:1:1: presets: no preset draft in this scene; it has none");
    CHECK(refusal(plain + "presets: {final: {fps: 3}}\n", "draft") ==
          "s.yaml:1:1: presets: no preset draft in this scene; it has final");
}

TEST_CASE("Presets are checked even when they are not used, where they stand", "[preset]") {
    const std::string plain = "grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 0.2}}}]\npresets:\n";
    CHECK(refusal(plain + "  draft: {fps: 0}\n")
              .starts_with("s.yaml:4:16: presets.draft.fps: 0 is out of range"));
    CHECK(refusal(plain + "  draft: {frmaes: 0}\n")
              .starts_with("s.yaml:4:11: presets.draft.frmaes: unknown key"));
    CHECK(refusal(plain + "  draft: {bodies: {1: {}}}\n")
              .starts_with("s.yaml:4:20: presets.draft.bodies.1: no such entry"));
    CHECK(refusal(plain + "  draft: {solver.beta: 3}\n")
              .starts_with("s.yaml:4:24: presets.draft.solver.beta: 3 is out"));
    CHECK(refusal(plain + "  draft: {fps: 3, fps: 4}\n")
              .starts_with("s.yaml:4:19: presets.draft.fps: is given twice"));
    CHECK(refusal(plain + "  draft: {bodies.0.shape.box.size: [1, 1, 1]}\n").find("has 2 kinds") !=
          std::string::npos);
    CHECK(refusal(plain + "  drafty: {}\n").find("did you mean draft?") != std::string::npos);
    CHECK(refusal(plain + "  draft: 5\n").starts_with("s.yaml:4:10: presets.draft: must be a mapping"));
    CHECK(refusal("presets: [a]\n" + plain.substr(0, plain.find("presets")))
              .starts_with("s.yaml:1:10: presets: must be"));
}
