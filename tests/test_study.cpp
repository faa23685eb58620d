#include "app/study.h"
#include "tests/columns.h"

#include <catch2/catch.hpp>

#include <set>

using namespace firn;

namespace {

const std::string elastic_ball =
    "grid_spacing: 0.1\nframes: 1\nfps: 8\ngravity: [0, 0, 0]\n"
    "solver: {integrator: explicit, transfer: flip, flip_blend: 1, precision: double, initial_volume: sampled, max_iterations: 500}\n"
    "materials: {snow: {nu: 0, xi: 0, theta_c: 0.9, theta_s: 1e9}}\n"
    "bodies: [{shape: {box: {center: [0, 0.8, 0], size: [0.4, 0.4, 0.4]}}, sampling: lattice, velocity: [0, -0.01, 0]}]\n";

}  // namespace

TEST_CASE("A study tries every other value of an axis once, and nothing else", "[study]") {
    const Setup own = make_setup(load_scene_text(elastic_ball, "ball.yaml").scene);
    for (const auto& axis : axis_names()) {
        CAPTURE(axis);
        std::set<std::string> names;
        for (const Trial& t : trials_along(own, {axis}, 1e-3)) {
            CHECK(t.axis == axis);
            CHECK(names.insert(t.name).second);
            CHECK((t.setup.solver.precision == own.solver.precision || axis == "precision"));
            CHECK((t.setup.solver.weights == own.solver.weights || axis == "weights"));
            CHECK((t.setup.solver.transfer == own.solver.transfer || axis == "transfer"));
            CHECK((t.setup.solver.integrator == own.solver.integrator || axis == "integrator"));
            CHECK((t.setup.solver.dt == own.solver.dt || axis == "dt"));
        }
        CHECK((axis == "tolerance") == names.empty());  // explicit steps have no solve
    }
    CHECK(*reference_trial(own, 1e-3).setup.solver.dt < 1e-3 / 4);
    CHECK(reference_trial(own, 1e-3).setup.solver.precision == Precision::twofold);
}

TEST_CASE("Deviations are lengths of shifts and shares of mass", "[study]") {
    ParticleSet start;
    std::vector<Vec3d> here, there, far;
    for (int i = 0; i < 64; ++i) {
        here.push_back(Vec3d(i % 4, i / 4 % 4, i / 16) * 0.5), start.m.push_back(1 + i % 3);
        there.push_back(here.back() + Vec3d(0.03, 0.04, 0)), far.push_back(here.back() + Vec3d(100, 0, 0));
    }
    CHECK(deviation(start, here, here, 0.5).density == 0);
    const Deviation near = deviation(start, here, there, 0.5);
    CHECK(near.root_mean_square == Approx(0.05));
    CHECK(near.largest == Approx(0.05));
    CHECK(near.density > 0.01);
    CHECK(near.density < 1);
    CHECK(deviation(start, here, far, 0.5).density == Approx(2));
}

TEST_CASE("A trial reaches the end of its span, or says why not", "[study]") {
    const OneThread one_thread;
    const LoadedScene loaded = load_scene_text(elastic_ball, "ball.yaml");
    const ParticleSet start = make_particles(loaded, 0.1).particles;
    Trial good;
    good.setup = make_setup(loaded.scene);
    run_trial(good, start, {1, 8});
    CHECK(good.failure == "");
    CHECK(good.simulated == Approx(1.0 / 8));
    CHECK(good.steps > 5);
    CHECK(good.x.size() == start.size());
    CHECK(good.x[0].y() == Approx(start.x[0].y() - 0.01 / 8).margin(1e-9));
    CHECK(std::abs(good.energy) < 1e-9 * good.energy_scale);
    Trial bad = good;
    bad.setup.gravity.x() = std::nan("");
    run_trial(bad, start, {1, 8});
    CHECK(bad.failure != "");
}

TEST_CASE("Explicit steps end where theory says, semi-implicit ones beyond", "[study]") {
    const OneThread one_thread;
    // A stretched elastic block swings freely.
    LoadedScene loaded = load_scene_text(elastic_ball, "ball.yaml");
    ParticleSet start = make_particles(loaded, 0.1).particles;
    for (Mat3d& F : start.Fe) F = Vec3d(1.002, 1, 1.001).asDiagonal();
    int below = 0, above = 0;
    for (const MapField& f : stability_fields(loaded, start, Integrator::explicit_euler, true)) {
        const double limit = explicit_limit(f.trial.setup);
        CAPTURE(f.along, f.dt, limit, f.trial.failure, f.trial.energy_made, f.trial.energy_scale, f.trial.rejected, f.trial.steps);
        // Nodes at a free surface carry less mass than the chain's: the limit is below it by up to two there.
        if (f.dt < 0.5 * limit) { ++below; CHECK(f.verdict != MapField::Verdict::failed); }
        // Beyond it the energy grows by a factor each step; it needs some steps to be seen.
        if (f.dt > 2 * limit && 1 / (8 * f.dt) > 8) { ++above; CHECK(f.verdict == MapField::Verdict::failed); }
    }
    CHECK(below > 10);
    CHECK(above > 5);
    for (const MapField& f : stability_fields(loaded, start, Integrator::semi_implicit, true))
        if (f.dt < 4 * explicit_limit(f.trial.setup)) {
            CAPTURE(f.along, f.dt, f.trial.failure, f.trial.energy_made, f.trial.energy_scale, f.trial.rejected, f.trial.unconverged);
            CHECK(f.verdict != MapField::Verdict::failed);
        }
}
