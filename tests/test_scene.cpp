#include "app/scene_load.h"
#include "app/scene_particles.h"
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>

#include <numbers>

using namespace firn;

static const std::string six_lines = "grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 0.2}}}]\n";

static LoadedScene load(const std::string& text, const Overrides& overrides = {}) {
    return load_scene_text(text, "scenes/ball.yaml", overrides);
}

TEST_CASE("A scene of two lines runs with the documented defaults", "[scene]") {
    const auto json = load(six_lines).resolved;
    CHECK(json["title"] == "ball");
    CHECK(json["frames"] == 48);
    CHECK(json["fps"] == 24);
    CHECK(json["gravity"] == nlohmann::ordered_json{0, -9.81, 0});
    CHECK(json["seed"] == 1);
    CHECK(
        json["solver"] ==
        nlohmann::ordered_json::parse(
            R"({"defaults": "firn", "integrator": "semi_implicit", "beta": 0.6, "stiff": "weighted",
                  "stiff_limit": "auto", "strain_limit": 0.02, "dt": "auto", "max_dt": 2e-3, "transfer": "flip",
                  "flip_damping": 50.0, "weights": "quadratic", "precision": "float", "initial_volume": "sampled",
                  "node_contact": "elastic", "linear_solver": "conjugate_gradient", "tolerance": 1e-2, "max_iterations": 100,
                  "rest_speed": 0.0, "rest_time": 0.1})"));
    CHECK(
        json["materials"] ==
        nlohmann::ordered_json::parse(
            R"({"snow": {"E": 1.4e5, "nu": 0.2, "xi": 10.0, "theta_c": 2.5e-2, 
                    "theta_s": 7.5e-3, "rho": 400.0, "max_density": 917.0}})"));
    const auto& body = json["bodies"][0];
    CHECK(body["material"] == "snow");
    CHECK(body["velocity"] == nlohmann::ordered_json{0, 0, 0});
    CHECK(body["angular_velocity"] == nlohmann::ordered_json{0, 0, 0});
    CHECK(body["particles_per_cell"] == 8);
    CHECK(body["sampling"] == "poisson_disk");
    CHECK(json["colliders"].empty());
    CHECK(json["camera"]["field_of_view"] == 40);
    CHECK(json["picture"]["width"] == 1280);
    CHECK(json["picture"]["height"] == 720);
    CHECK(json["picture"]["quality"] == "final");
}

TEST_CASE("With defaults: paper, what is not given is the paper's", "[scene]") {
    const auto resolved = [](const std::string& solver) { return load(six_lines + "solver: {" + solver + "}\n").resolved; };
    const auto paper = resolved("defaults: paper");
    CHECK(paper["solver"] == nlohmann::ordered_json::parse(
            R"({"defaults": "paper", "integrator": "semi_implicit", "beta": 1.0, "stiff": "all",
                  "stiff_limit": "auto", "strain_limit": 0.2, "dt": "auto", "max_dt": 1e-3, "transfer": "flip",
                  "flip_blend": 0.95, "weights": "cubic", "precision": "float", "initial_volume": "grid",
                  "node_contact": "inelastic", "linear_solver": "conjugate_residual", "tolerance": 1e-4, "max_iterations": 30,
                  "rest_speed": 0.0, "rest_time": 0.1})"));
    CHECK(paper["materials"]["snow"]["max_density"] == 1e9);
    CHECK(resolved("defaults: paper, weights: quadratic")["solver"]["weights"] == "quadratic");
    CHECK(resolved("weights: quadratic, defaults: paper")["solver"]["tolerance"] == 1e-4);
    CHECK(to_json(read_resolved(paper, "run.json")) == paper);
}

TEST_CASE("A velocity's share of FLIP is given by the second or by the step, not both", "[scene]") {
    const auto solver = [](const std::string& keys) { return load(six_lines + "solver: {" + keys + "}\n").resolved["solver"]; };
    CHECK(solver("flip_blend: 0.9")["flip_blend"] == 0.9);
    CHECK_FALSE(solver("flip_blend: 0.9").contains("flip_damping"));
    CHECK(solver("defaults: paper, flip_damping: 7")["flip_damping"] == 7);
    CHECK_FALSE(solver("defaults: paper, flip_damping: 7").contains("flip_blend"));
    CHECK_THROWS_WITH(solver("flip_damping: 7, flip_blend: 0.9"), Catch::Contains("3:39") && Catch::Contains("keep one"));
}

TEST_CASE("Every key is read into its place", "[scene]") {
    const auto scene = load(R"(
title: "All keys: every one"
frames: 3
fps: 30
grid_spacing: 0.05
gravity: [1, 2, 3]
seed: 9007199254740992
solver: {integrator: explicit, beta: 0.4, stiff: all, stiff_limit: 0.3, strain_limit: 0.01,
         dt: 1e-4, max_dt: 2e-3, transfer: apic, flip_blend: 0.9,
         weights: quadratic, precision: double, initial_volume: grid, tolerance: 1e-6, max_iterations: 7,
         rest_speed: 0.03, rest_time: 0.2}
materials: {ice: {E: 1e6, nu: 0.3, xi: 5, theta_c: 0, theta_s: 1e6, rho: 900}, powder: {}}
bodies:
  - {material: powder, velocity: [4, 5, 6], angular_velocity: [7, 8, 9], particles_per_cell: 2,
     sampling: lattice, lumps: {size: 0.2, core: 0.8, seam: 1.5},
     shape: {difference: [{union: [{box: {center: [0, 1, 0], size: [1, 2, 3]}}, {ellipsoid: {radii: [1, 2, 3]}}]},
                          {plane: {normal: [1, 0, 0]}},
                          {cylinder: {from: [0, 0, 0], to: [0, 1, 0], radius: 0.1}}]}}
colliders:
  - {shape: {capsule: {from: [0, 0, 0], to: [1, 0, 0], radius: 2}}, contact: sticky,
     friction: 0.7, velocity: [1, 0, 0]}
camera: {eye: [1, 2, 3], target: [4, 5, 6], field_of_view: 50}
picture: {width: 100, height: 50, quality: preview, sun_azimuth: 10, sun_elevation: 20, exposure: 2}
)")
                           .scene;
    CHECK(scene.title == "All keys: every one");
    CHECK(scene.frames == 3);
    CHECK(scene.fps == 30);
    CHECK(scene.grid_spacing == 0.05);
    CHECK(scene.gravity == Vec3d(1, 2, 3));
    CHECK(scene.seed == 9007199254740992);
    CHECK(scene.solver.integrator == Integrator::explicit_euler);
    CHECK(scene.solver.beta == 0.4);
    CHECK(scene.solver.stiff == Stiff::all);
    CHECK(scene.solver.stiff_limit == 0.3);
    CHECK(scene.solver.strain_limit == 0.01);
    CHECK(scene.solver.dt == 1e-4);
    CHECK(scene.solver.max_dt == 2e-3);
    CHECK(scene.solver.transfer == Transfer::apic);
    CHECK(scene.solver.flip_blend == 0.9);
    CHECK(scene.solver.weights == Weights::quadratic);
    CHECK(scene.solver.precision == Precision::twofold);
    CHECK(scene.solver.initial_volume == InitialVolume::grid);
    CHECK(scene.solver.tolerance == 1e-6);
    CHECK(scene.solver.max_iterations == 7);
    CHECK(scene.solver.rest_speed == 0.03);
    CHECK(scene.solver.rest_time == 0.2);
    const Snow ice = scene.materials.at("ice");
    CHECK(std::vector{ice.E, ice.nu, ice.xi, ice.theta_c, ice.theta_s, ice.rho} ==
          std::vector{1e6, 0.3, 5.0, 0.0, 1e6, 900.0});
    CHECK(scene.materials.at("powder").E == 1.4e5);
    const SceneBody& body = scene.bodies.at(0);
    CHECK(body.material == "powder");
    CHECK(body.velocity == Vec3d(4, 5, 6));
    CHECK(body.angular_velocity == Vec3d(7, 8, 9));
    CHECK(body.particles_per_cell == 2);
    CHECK(body.sampling == Sampling::lattice);
    REQUIRE(body.lumps);
    CHECK(std::vector{body.lumps->size, body.lumps->core, body.lumps->seam} == std::vector{0.2, 0.8, 1.5});
    const auto& parts = std::get<Difference>(body.shape).shapes;
    REQUIRE(parts.size() == 3);
    const auto& joined = std::get<Union>(parts[0]).shapes;
    CHECK(std::get<Box>(joined[0]).size == Vec3d(1, 2, 3));
    CHECK(std::get<Ellipsoid>(joined[1]).radii == Vec3d(1, 2, 3));
    CHECK(std::get<Plane>(parts[1]).normal == Vec3d(1, 0, 0));
    CHECK(std::get<Cylinder>(parts[2]).radius == 0.1);
    const Collider& collider = scene.colliders.at(0);
    CHECK(std::get<Capsule>(collider.shape).to == Vec3d(1, 0, 0));
    CHECK(collider.contact == ContactLaw::sticky);
    CHECK(collider.friction == 0.7);
    CHECK(collider.velocity == Vec3d(1, 0, 0));
    CHECK(scene.camera->target == Vec3d(4, 5, 6));
    CHECK(scene.camera->field_of_view == 50);
    CHECK(scene.picture.quality == Quality::preview);
    CHECK(scene.picture.sun_azimuth == 10);
    CHECK(scene.picture.sun_elevation == 20);
    CHECK(scene.picture.exposure == 2);
    CHECK(make_setup(scene).materials.at(0).rho == 900);
}

TEST_CASE("A resolved scene reads back as itself", "[scene]") {
    const auto first = load(
        six_lines + "solver: {dt: 0.1}\ncolliders: [{shape: {plane: {}}}]\ngravity: [0, -1e-300, 1e5]\n");
    CHECK(to_json(read_resolved(first.resolved, "run.json")) == first.resolved);
    CHECK(load(first.resolved.dump()).hash == first.hash);
}

TEST_CASE("The hash follows what frames depend on, and nothing else", "[scene]") {
    const std::string hash = load(six_lines).hash;
    CHECK(hash.size() == 32);
    CHECK(load("# a comment\n" + six_lines + "fps: 24.0\n").hash == hash);
    CHECK(load(six_lines + "frames: 7\n").hash == hash);
    CHECK(load(six_lines + "fps: 25\n").hash != hash);
    CHECK(load(six_lines + "picture: {exposure: 1.1}\n").hash != hash);
    const TempFolder folder;
    const auto particles_hash = [&](const std::string& x) {
        folder.write("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                              "property float z\nend_header\n" + x + " 0 0\n");
        return load_scene_text("grid_spacing: 0.1\nbodies: [{particles: a.ply}]\n"
                               "camera: {eye: [0, 0, 1], target: [0, 0, 0]}\n",  // else it follows the particles
                               folder / "s.yaml").hash;
    };
    CHECK(particles_hash("0") == particles_hash("0"));
    CHECK(particles_hash("0") != particles_hash("1"));
}

TEST_CASE("A camera keeps what is given and frames the bodies with the rest", "[scene]") {
    const Camera whole = *load(six_lines).scene.camera;
    const Camera aimed = *load(six_lines + "camera: {target: [5, 0, 0]}\n").scene.camera;
    const Camera narrow = *load(six_lines + "camera: {field_of_view: 20}\n").scene.camera;
    CHECK(aimed.target == Vec3d(5, 0, 0));
    CHECK((aimed.eye - aimed.target - (whole.eye - whole.target)).norm() < 1e-12);
    CHECK((narrow.eye - narrow.target).norm() > 2 * (whole.eye - whole.target).norm());
}

TEST_CASE("A camera that is not given sees the ground on which the bodies will fall", "[scene]") {
    const auto lowest_seen = [](const std::string& colliders) {
        const Camera camera = *load(six_lines + colliders).scene.camera;
        const Vec3d forward = (camera.target - camera.eye).normalized();
        const double half = camera.field_of_view / 2 * std::numbers::pi / 180;
        // Where the ray at the picture's lower edge passes below the bodies' middle.
        const double steep = std::asin(-forward.y()) + half;
        const Vec3d way = camera.eye - camera.target;
        return camera.eye.y() - std::tan(steep) * std::hypot(way.x(), way.z());
    };
    const std::string plane = "colliders:\n  - shape: {plane: {point: [0, ";
    const double none = lowest_seen("");
    CHECK(lowest_seen(plane + "-1, 0]}}\n") < -1);
    CHECK(lowest_seen(plane + "-1, 0], normal: [1, 1, 0]}}\n") < none);
    CHECK(lowest_seen(plane + "-1, 0]}}\n  - shape: {plane: {point: [0, -0.4, 0]}}\n") ==
          lowest_seen(plane + "-0.4, 0]}}\n"));  // snow stops at the upper one
    CHECK(lowest_seen(plane + "-100, 0]}}\n") == none);                   // bodies would be dots
    CHECK(lowest_seen(plane + "-1, 0], normal: [0, -1, 0]}}\n") == none);  // a ceiling
    CHECK(lowest_seen(plane + "-1, 0], normal: [1, 0.1, 0]}}\n") == none);  // a wall
}

TEST_CASE("A file of particles gives what it has; the body completes the rest", "[scene]") {
    const TempFolder folder;
    folder.write(
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "end_header\n0 0 0\n2 0 0\n");
    const auto loaded = load_scene_text(
        "grid_spacing: 0.5\nmaterials: {snow: {rho: 160}}\n"
        "bodies: [{particles: a.ply, particles_per_cell: 4, velocity: [1, 0, 0], "
        "angular_velocity: [0, 0, 3]}]\n",
        folder / "s.yaml");
    const ParticleSet set = make_particles(loaded, 0.5).particles;
    REQUIRE(set.size() == 2);
    CHECK(set.m[0] == 160 * 0.125 / 4);  // ρ₀ h³ / particles_per_cell
    CHECK(set.V0[0] == 0);
    CHECK(set.Jp[0] == 1);
    CHECK(set.Fe[1] == Mat3d::Identity());
    CHECK(set.v[0] == Vec3d(1, -3, 0));  // about the centre of mass, (1, 0, 0)
    CHECK(set.v[1] == Vec3d(1, 3, 0));
}

TEST_CASE("A body of lumps turns about its own centre of mass", "[scene]") {
    const auto loaded = load(
        "grid_spacing: 0.05\n"
        "bodies: [{shape: {sphere: {radius: 0.2}}, velocity: [1, 2, 3], angular_velocity: [0, 0, 50], "
        "lumps: {size: 0.2, core: 0.6, seam: 2}}]\n");
    const ParticleSet set = make_particles(loaded, 0.05).particles;
    Vec3d momentum = Vec3d::Zero();
    double mass = 0;
    for (std::size_t p = 0; p < set.size(); ++p) momentum += set.m[p] * set.v[p], mass += set.m[p];
    CHECK((momentum / mass - Vec3d(1, 2, 3)).norm() < 1e-12);
}

TEST_CASE("Bodies without particles are refused, overlaps are told", "[scene]") {
    const auto tiny = load(
        "grid_spacing: 0.1\nbodies:\n  - shape: {sphere: {radius: 0.2}}\n  - shape: {sphere: {radius: "
        "0.001}}\n");
    CHECK_THROWS_WITH(make_particles(tiny, 0.1),
                      Catch::Contains("ball.yaml:4:5: bodies.1: has no particles"));
    const auto far =
        load("grid_spacing: 0.1\nbodies: [{shape: {sphere: {center: [1e5, 0, 0], radius: 0.2}}}]\n");
    CHECK_THROWS_WITH(make_particles(far, 0.1),
                      Catch::Contains("bodies.0: reaches farther from the origin than 26214.4 m"));
    const auto warnings =
        make_particles(load("grid_spacing: 0.1\nbodies:\n  - shape: {sphere: {radius: 0.3}}\n"
                            "  - shape: {sphere: {center: [0.1, 0, 0], radius: 0.3}}\n"
                            "colliders: [{shape: {plane: {point: [0, -0.1, 0]}}}]\n"),
                       0.1)
            .warnings;
    REQUIRE(warnings.size() == 3);
    CHECK(warnings[0].starts_with("scenes/ball.yaml:3:5: bodies.0: warning: about"));
    CHECK(warnings[0].find("inside colliders.0") != std::string::npos);
    CHECK(warnings[2].find("inside bodies.0") != std::string::npos);
    CHECK(make_particles(load(six_lines), 0.1).warnings.empty());
}

TEST_CASE("A body whose particles have another volume than their mass is told", "[scene]") {
    const auto warnings = [](const std::string& radius, const std::string& volume, double coarser = 1) {
        const LoadedScene loaded = load("grid_spacing: 0.1\nsolver: {initial_volume: " + volume +
                                        "}\nbodies:\n  - shape: {sphere: {radius: " + radius + "}}\n");
        const StartingParticles start = make_particles(loaded, 0.1);
        const auto V0 = make_simulation(make_setup(loaded.scene), ParticleSet(start.particles))->volumes();
        return volume_warnings(loaded, start.counts, start.volumes, V0, coarser * 0.1);
    };
    REQUIRE(warnings("0.3", "grid").size() == 1);
    CHECK_THAT(warnings("0.3", "grid")[0], Catch::StartsWith("scenes/ball.yaml:4:5: bodies.0: warning: its particles have 1.49 times") &&
                                               Catch::EndsWith("set solver.initial_volume: sampled"));
    CHECK(warnings("0.3", "sampled").empty());
    CHECK(warnings("1.2", "grid").empty());             // 12 h
    CHECK(warnings("0.3", "grid", 3).empty());          // on a grid as fine as the scene's it would be 1.19

    LoadedScene loaded = load("grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 0.3}}}]\n");
    loaded.files[0].volume = {1e-3, 2e-3};
    CHECK(volume_warnings(loaded, {2}, {2.6e-3}, {1e-3f, 2e-3f}, 0.1).empty());
    const auto own = volume_warnings(loaded, {2}, {2e-3}, {1e-3f, 2e-3f}, 0.1);
    REQUIRE(own.size() == 1);
    CHECK_THAT(own[0], Catch::Contains("1.5 times") && Catch::EndsWith("set rho to 267, or take the volumes out of the file"));
}

TEST_CASE("Parts lie as far apart as they like; what would keep sampling busy for hours, or is too thin, is refused where it stands", "[scene]") {
    const auto apart = [](const std::string& distance, const std::string& sampling) {
        return load("grid_spacing: 0.02\nbodies:\n  - sampling: " + sampling +
                    "\n    shape: {union: [{sphere: {radius: 0.1}}, {sphere: {center: [" + distance + ", " + distance +
                    ", " + distance + "], radius: 0.1}}]}\n");
    };
    for (const char* sampling : {"poisson_disk", "lattice", "random"}) {     // however far apart
        const StartingParticles start = make_particles(apart("100", sampling), 0.02);
        CHECK(start.counts[0] == Approx(2 * 4189).epsilon(0.05));
        CHECK(start.volumes[0] == Approx(2 * 4.18879e-3).epsilon(1e-3));
    }
    CHECK_THROWS_WITH(make_particles(load("grid_spacing: 0.02\nbodies: [{shape: {box: {size: [1e4, 1e-6, 1e4]}}}]\n"), 0.02),
                      Catch::Contains("bodies.0.shape: has so much surface"));
    const std::string sheet = "{box: {center: [0, 1, 0], size: [20, 1e-3, 20]}}";
    CHECK_THROWS_WITH(make_particles(load("grid_spacing: 0.1\nbodies:\n  - shape: {union: [" + sheet + ", {sphere: {radius: 0.01}}]}\n"), 0.1),
                      Catch::Contains("ball.yaml:3:5: bodies.0: is thinner than its particles are apart, 0.05 m"));
}

TEST_CASE("Aliases, block style, a byte order mark and Windows line ends are read", "[scene]") {
    CHECK(load("grid_spacing: 0.1\nbodies:\n  - &a {shape: {sphere: {radius: 0.2}}}\n  - *a\n")
              .scene.bodies.size() == 2);
    CHECK(load("\xEF\xBB\xBFgrid_spacing: 0.1\r\nfps: 25 # film\r\nbodies:\r\n  - shape: {sphere: {radius: "
               "0.2}}\r\n")
              .scene.fps == 25);
    CHECK(load("---\n" + six_lines + "...\n").scene.fps == 24);
    CHECK(load(six_lines + "title: Schneebälle ❄\n").scene.title == "Schneebälle ❄");
    CHECK(load(six_lines + "title: \"a 'quoted' word\"\n").scene.title == "a 'quoted' word");
    CHECK(load(six_lines + "title: 'it''s'\n").scene.title == "it's");
    CHECK(load(six_lines + "fps: +2.5e1\n").scene.fps == 25);
}

TEST_CASE("Numbers are read the same in every locale", "[scene]") {
    const char* const german = std::setlocale(LC_ALL, "de_DE.UTF-8");
    CHECK(load(six_lines + "fps: 2.5\n").scene.fps == 2.5);
    if (!german) WARN("no locale with a decimal comma is installed");
    std::setlocale(LC_ALL, "C");
}
