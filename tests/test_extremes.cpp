#include "sim/simulation.h"
#include "tests/sanitizers.h"

#include <catch2/catch.hpp>
#include <omp.h>

#include <cmath>
#include <cstring>
#include <functional>

using namespace firn;

// Whatever is asked for ends in one of two ways: in numbers that can be, or in an error that says what to change.

namespace {

struct Case {
    std::string name;
    std::function<void(Setup&, Body&)> change = [](Setup&, Body&) {};
    std::function<void(ParticleSet&)> disturb = [](ParticleSet&) {};
};

/// A ball that falls on a ground and against a post.
Setup plain_setup() {
    Setup s;
    s.h = 0.1;
    s.materials = {Snow{}};
    s.solver.weights = Weights::quadratic;
    Collider ground, post;
    ground.shape = Plane{{0, 0, 0}, {0, 1, 0}};
    post.shape = Capsule{{0.3, -1, 0}, {0.3, 1, 0}, 0.1};
    post.contact = ContactLaw::sticky;
    s.colliders = {ground, post};
    return s;
}
Body plain_body() {
    Body b;
    b.shape = Sphere{{0, 0.25, 0}, 0.2};
    b.velocity = {3, -4, 0};
    b.particles_per_cell = 6;
    b.sampling = Sampling::random;  // a Poisson tile of 4000 points would take far longer than the steps
    return b;
}

Collider moving(const Shape& shape, const Vec3d& velocity) {
    Collider c;
    c.shape = shape, c.velocity = velocity;
    return c;
}

std::vector<Case> cases() {
    std::vector<Case> all{{"plain"}};
    const auto setting = [&](const std::string& name, const std::vector<double>& values, auto set) {
        for (const double a : values)
            all.push_back({name + " = " + std::to_string(a), [=](Setup& s, Body& b) { set(s, b, a); }});
    };
    const auto snow = [](double Snow::*key) { return [key](Setup& s, Body&, double a) { s.materials[0].*key = a; }; };
    setting("E", {1e2, 1e4, 1e6, 1e8, 1e10}, snow(&Snow::E));
    setting("nu", {-0.9, -0.5, 0, 0.45, 0.499}, snow(&Snow::nu));
    setting("xi", {0, 1, 30, 100, 1e4}, snow(&Snow::xi));
    setting("theta", {0, 1e-6, 0.5, 0.999}, [](Setup& s, Body&, double a) {
        s.materials[0].theta_c = a, s.materials[0].theta_s = a < 0.9 ? a : 1e9; });
    setting("rho", {1, 30, 900, 2e4}, snow(&Snow::rho));
    setting("speed", {0.1, 10, 100, 1000}, [](Setup&, Body& b, double a) { b.velocity = {a * 0.6, -a * 0.8, 0}; });
    setting("dt", {1e-8, 1e-5, 1e-3, 1e-2, 1}, [](Setup& s, Body&, double a) { s.solver.dt = a; });
    setting("h", {1e-4, 1e-2, 1, 10}, [](Setup& s, Body& b, double a) {
        s.h = a;
        b.shape = Sphere{Vec3d(0, 2.5, 0) * a, 2 * a};
        s.colliders[1].shape = Capsule{Vec3d(3, -10, 0) * a, Vec3d(3, 10, 0) * a, a};
    });
    setting("gravity", {0, 9810}, [](Setup& s, Body&, double a) { s.gravity = {0, -a, 0}; });
    setting("farther", {1e3, 1e6, 1e12, 1e30}, [](Setup& s, Body& b, double a) {
        s.colliders.clear();
        b.shape = Sphere{{a, 0, 0}, 0.2};
        if (a > 1e6) b.shape = Sphere{{0, 0, 0}, 0.2}, b.velocity = {a, 0, 0};
    });
    all.push_back({"collider inside", [](Setup& s, Body&) { s.colliders.push_back(moving(Sphere{{0, 0.25, 0}, 0.08}, {0, 0, 0})); }});
    all.push_back({"collider at 100 m/s", [](Setup& s, Body& b) {
        b.velocity = {0, 0, 0};
        s.colliders = {moving(Box{{-1, 0.2, 0}, {1, 1, 1}}, {100, 0, 0})};
    }});
    all.push_back({"colliders that meet", [](Setup& s, Body& b) {
        b.velocity = {0, 0, 0};
        s.colliders = {moving(Box{{-1, 0.25, 0}, {1, 2, 2}}, {10, 0, 0}), moving(Box{{1, 0.25, 0}, {1, 2, 2}}, {-10, 0, 0})};
    }});
    all.push_back({"thin sticky plate", [](Setup& s, Body& b) {
        s.colliders[1].shape = Box{{0, 0, 0}, {0.02, 2, 2}};
        b.shape = Sphere{{0, 0.25, 0}, 0.2}, b.velocity = {0, -6, 0};
    }});
    const auto disturbed = [&](const std::string& name, auto f) { all.push_back({name, [](Setup&, Body&) {}, f}); };
    disturbed("one particle", [](ParticleSet& p) { p = ParticleSet(p); p.x.resize(1), p.v.resize(1), p.Fe.resize(1), p.Jp.resize(1), p.m.resize(1), p.V0.resize(1), p.material.resize(1); });
    disturbed("two at one point", [](ParticleSet& p) { p.x[1] = p.x[0]; });
    disturbed("all in a line", [](ParticleSet& p) {
        for (std::size_t i = 0; i < p.size(); ++i) p.x[i] = {1e-5 * double(i), 0.25, 0}; });
    disturbed("F_E inverted", [](ParticleSet& p) { p.Fe[3](0, 0) = -1; });
    disturbed("F_E singular", [](ParticleSet& p) { p.Fe[3].col(1) = p.Fe[3].col(0); });
    disturbed("F_E zero", [](ParticleSet& p) { p.Fe[3].setZero(); });
    disturbed("F_E huge", [](ParticleSet& p) { p.Fe[3] *= 1e20; });
    disturbed("F_E large", [](ParticleSet& p) { p.Fe[3] *= 10; });
    disturbed("F_E not a number", [](ParticleSet& p) { p.Fe[3](2, 2) = std::nan(""); });
    disturbed("J_P zero", [](ParticleSet& p) { p.Jp[3] = 0; });
    disturbed("v infinite", [](ParticleSet& p) { p.v[3].x() = INFINITY; });
    return all;
}

std::vector<double> numbers(const ParticleRows& rows) {
    std::vector<double> values(rows.count * rows.columns.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        float single;
        if (rows.twofold) std::memcpy(&values[i], rows.data.data() + 8 * i, 8);
        else std::memcpy(&single, rows.data.data() + 4 * i, 4), values[i] = single;
    }
    return values;
}

/// Runs the case. Returns the error's text, or nothing.
std::string run(const Case& c, Integrator integrator, Precision precision) {
    Setup setup = plain_setup();
    Body body = plain_body();
    setup.solver.integrator = integrator, setup.solver.precision = precision;
    c.change(setup, body);
    ParticleSet start = sample(body, setup.materials[0].rho, setup.h, 1, 0);
    c.disturb(start);
    const bool pushed = std::any_of(setup.colliders.begin(), setup.colliders.end(),
                                    [](const Collider& k) { return k.velocity.norm() > 0; });
    try {
        const auto sim = make_simulation(setup, std::move(start));
        const Totals first = sim->totals();
        double given = first.kinetic + first.elastic, low = first.potential, high = low;
        Vec3d impulse = first.momentum;
        const int steps = integrator == Integrator::explicit_euler ? tries(40, 10) : tries(15, 5);
        for (int n = 0; n < steps && sim->time() < 1; ++n) {
            const StepReport report = sim->step(1.0 / 24);
            impulse += first.mass * setup.gravity * report.dt;
            const Totals now = sim->totals();
            low = std::min(low, now.potential), high = std::max(high, now.potential);
            REQUIRE(now.mass == Approx(first.mass).epsilon(1e-12));
            if (!pushed) REQUIRE(now.kinetic + now.elastic <= 2.01 * (given + high - low) + 1e-6 * setup.materials[0].E * std::pow(setup.h, 3));
            if (setup.colliders.empty())
                REQUIRE((now.momentum - impulse).norm() <= 1e-3 * first.mass * (first.momentum.norm() / first.mass + setup.gravity.norm() * sim->time()));
        }
        const ParticleRows rows = sim->rows(true);
        const std::vector<double> all = numbers(rows);
        const auto Jp = std::size_t(std::find(rows.columns.begin(), rows.columns.end(), "Jp") - rows.columns.begin());
        for (const double a : all) REQUIRE(std::isfinite(a));
        for (std::size_t p = 0; p < rows.count; ++p) REQUIRE(all[p * rows.columns.size() + Jp] > 0);
    } catch (const SimulationError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("at every extreme a run ends in numbers that can be, or says what to change", "[extremes]") {
    const auto integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    const auto precision = GENERATE(Precision::single, Precision::twofold);
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);                             // these are too small to share
    for (const Case& c : cases()) {
        INFO(c.name << ", integrator " << int(integrator) << ", precision " << int(precision));
        const std::string error = run(c, integrator, precision);
        if (!error.empty()) CHECK_THAT(error, Catch::Contains("step ") && Catch::Contains("a smaller solver.dt"));
    }
    omp_set_num_threads(threads);
}

TEST_CASE("a million particles in a line within one cell are stepped", "[extremes]") {
    Setup setup = plain_setup();
    ParticleSet crowd;
    const int count = tries(1'000'000, 100'000);
    for (int i = 0; i < count; ++i) {
        crowd.x.push_back({1e-7 * i, 0.25, 0}), crowd.v.push_back({3, -4, 0}), crowd.Fe.push_back(Mat3d::Identity());
        crowd.Jp.push_back(1), crowd.m.push_back(1e-3), crowd.V0.push_back(0), crowd.material.push_back(0);
    }
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    const auto sim = make_simulation(setup, std::move(crowd));
    const Totals before = sim->totals();
    CHECK(before.mass == Approx(1e-3 * count));
    for (int step = 0; step < 2; ++step) sim->step(1e-3);
    const Totals after = sim->totals();
    CHECK(after.mass == Approx(before.mass));
    CHECK(after.kinetic + after.elastic + after.potential < before.kinetic + before.elastic + before.potential + 1);
}
