#include "sim/collision.h"
#include "sim/simulation.h"
#include "tests/columns.h"

#include <catch2/catch.hpp>

#include <sstream>

using namespace firn;

namespace {

/// A slab of snow that nothing touches, without gravity.
Setup floating_setup() {
    Setup s;
    s.h = 0.1;
    s.gravity = {0, 0, 0};
    s.materials = {Snow{}};
    s.solver.precision = Precision::twofold;
    s.solver.weights = Weights::quadratic;
    s.solver.tolerance = 1e-10;
    s.solver.max_iterations = 1000;
    s.solver.dt = 5e-4;
    s.solver.rest_speed = 0.02;
    s.solver.rest_time = 4.5e-4;
    return s;
}

Body slab() {
    Body b;
    b.shape = Box{{0, 0, 0}, {2.4, 0.6, 0.5}};
    b.particles_per_cell = 2;
    return b;
}

/// A ball that comes to the slab's one end.
Body ball(double speed) {
    Body b;
    b.shape = Sphere{{0.9, 0.56, 0}, 0.16};
    b.velocity = {0, -speed, 0};
    b.particles_per_cell = 4;
    return b;
}

ParticleSet slab_and_ball(double speed) {
    ParticleSet all = sample(slab(), 400, 0.1, 1, 0);
    all.append(sample(ball(speed), 400, 0.1, 2, 0));
    return all;
}

/// A slab on the ground, as heavy as it is.
Setup lying_setup() {
    Setup s = floating_setup();
    Collider ground;
    ground.shape = Plane{{0, -0.3, 0}, {0, 1, 0}};
    s.colliders = {ground};
    s.gravity = {0, -9.81, 0};
    s.solver.precision = Precision::single;
    s.solver.integrator = Integrator::explicit_euler;
    s.solver.dt = {}, s.solver.max_dt = 1e-3;     // what is slow is damped by the step
    s.solver.rest_speed = 0.1;  // it rings at g L/c = 0.3 m/s
    s.solver.rest_time = 0.03;
    return s;
}

/// Steps up to the time t; returns the last report.
StepReport go_to(Simulation& sim, double t) {
    StepReport last;
    while (sim.time() < t * (1 - 1e-9)) last = sim.step(t - sim.time());
    return last;
}

double farthest(const std::vector<float>& a, const std::vector<float>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(double(a[i]) - double(b[i])));
    return most;
}

/// Steps until all of it sleeps; false if that takes more than two seconds.
bool falls_asleep(Simulation& sim) {
    while (sim.time() < 2)
        if (sim.step(1).asleep == sim.size()) return true;
    return false;
}

}  // namespace

TEST_CASE("what rests sleeps, wakes where it is hit, and keeps mass and momentum", "[rest]") {
    Setup setup = floating_setup();
    setup.solver.integrator =
        GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    setup.solver.transfer = GENERATE(Transfer::flip, Transfer::apic);
    const auto sim = make_simulation(setup, slab_and_ball(4));
    const Totals start = sim->totals();
    std::size_t most = 0, least = sim->size();
    for (int step = 0; step < 60; ++step) {
        const StepReport report = sim->step(1);
        most = std::max(most, report.asleep);
        if (step > 5) least = std::min(least, report.asleep);
        const Totals now = sim->totals();
        REQUIRE(now.mass == Approx(start.mass).epsilon(1e-14));
        REQUIRE((now.momentum - start.momentum).norm() < 1e-12 * start.momentum.norm());
    }
    CAPTURE(int(setup.solver.integrator), int(setup.solver.transfer), sim->size());
    CHECK(most > sim->size() / 2);  // the slab slept
    CHECK(least < most - 200);      // and was woken where the ball hit
}

TEST_CASE("snow that wakes at once at the least motion moves as if it had never slept", "[rest]") {
    Setup setup = floating_setup();
    setup.solver.integrator =
        GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    setup.solver.rest_speed = 1e-11;
    const auto sleeper = make_simulation(setup, slab_and_ball(4));
    setup.solver.rest_speed = 0;
    const auto waker = make_simulation(setup, slab_and_ball(4));
    std::size_t slept = 0;
    for (int step = 0; step < 25; ++step) {
        slept += sleeper->step(1).asleep;
        REQUIRE(waker->step(1).asleep == 0);
    }
    CAPTURE(int(setup.solver.integrator));
    CHECK(slept > sleeper->size());
    const ParticleRows a = sleeper->rows(true), b = waker->rows(true);
    double velocities = 0, strains = 0;
    for (std::size_t p = 0; p < a.count; ++p) {
        velocities = std::max(velocities, (velocity(a, p) - velocity(b, p)).norm());
        strains = std::max(strains, std::abs(value(a, p, "Fe_11") - value(b, p, "Fe_11")));
    }
    CHECK(velocities < 1e-6);  // of 4 m/s
    CHECK(strains < 1e-7);
}

TEST_CASE("a slab that lies falls asleep as a whole, and then stays the same to the bit", "[rest]") {
    Setup setup = lying_setup();
    const auto sim = make_simulation(setup, sample(slab(), 400, 0.1, 1, 0));
    REQUIRE(falls_asleep(*sim));
    const std::vector<float> before = sim->positions();
    int still = 0;
    for (; still < 20 && sim->step(1).asleep == sim->size(); ++still) REQUIRE(sim->positions() == before);
    CHECK(still > 5);
}

TEST_CASE("sleep costs no more than the ways of what is slower", "[rest]") {
    Setup setup = lying_setup();
    const auto sleeper = make_simulation(setup, slab_and_ball(2));
    setup.solver.rest_speed = 0;
    const auto waker = make_simulation(setup, slab_and_ball(2));
    const StepReport report = go_to(*sleeper, 0.5);
    go_to(*waker, 0.5);
    CHECK(report.asleep > sleeper->size() / 2);
    CHECK(farthest(sleeper->positions(), waker->positions()) < 0.1 * 0.5);
}

TEST_CASE("a moving body wakes what it comes near", "[rest]") {
    Setup setup = floating_setup();
    setup.solver.integrator = Integrator::explicit_euler;
    Collider plough;  // thinner than a cell: it meets particles before nodes
    plough.shape = Box{{-2, 0, 0}, {0.05, 1, 1}};
    plough.velocity = {10, 0, 0};
    setup.colliders = {plough};
    const auto sim = make_simulation(setup, sample(slab(), 400, 0.1, 1, 0));
    CHECK(go_to(*sim, 0.01).asleep > sim->size() / 2);
    go_to(*sim, 0.1);  // from x = −2 to −1; the slab begins at −1.2
    const std::vector<float> x = sim->positions();
    for (std::size_t p = 0; p < sim->size(); ++p) REQUIRE(x[3 * p] > -1.05);
}

TEST_CASE("a moving body that slips between the nodes wakes what it meets", "[rest]") {
    Setup setup = floating_setup();
    setup.solver.integrator = Integrator::explicit_euler;
    Collider rod;  // 0.03 m from the nearest nodes
    rod.shape = Capsule{{-4, 0.05, 0.05}, {-2.2, 0.05, 0.05}, 0.04};
    rod.velocity = {10, 0, 0};
    setup.colliders = {rod};
    Body b = slab();
    b.particles_per_cell = 8;
    const auto sim = make_simulation(setup, sample(b, 400, 0.1, 1, 0));
    CHECK(go_to(*sim, 0.005).asleep == sim->size());
    go_to(*sim, 0.14);  // its end has gone from x = −2.16 to −0.76; the slab begins at −1.2
    const std::vector<float> x = sim->positions();
    for (std::size_t p = 0; p < sim->size(); ++p)  // none is deeper in it than it moves in two steps
        REQUIRE(signed_distance(rod, {x[3 * p], x[3 * p + 1], x[3 * p + 2]}, sim->time()) > -0.01);
}

TEST_CASE("what sleeps wakes at once where what bore it is gone", "[rest]") {
    Setup setup = lying_setup();
    const ParticleSet snow = sample(slab(), 400, 0.1, 1, 0);
    const auto lying = make_simulation(setup, ParticleSet(snow));
    REQUIRE(falls_asleep(*lying));
    std::stringstream state;
    lying->save(state);
    setup.colliders.clear();
    setup.solver.dt = 1e-4;  // in which gravity makes nothing faster than rest_speed
    const auto falling = make_simulation(setup, ParticleSet(snow));
    falling->restore(state);
    CHECK(falling->step(1).asleep < falling->size());
    CHECK(falling->totals().kinetic < falling->totals().mass * 0.1 * 0.1 / 2);
}

TEST_CASE("what is slow at the top of its way does not hang there", "[rest]") {
    Setup setup = floating_setup();
    setup.gravity = {0, -9.81, 0};
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit);
    setup.solver.rest_time = 1e-3;  // its speed is below rest_speed for 4 ms
    Body b = slab();
    b.velocity = {0, 1, 0};
    const auto sim = make_simulation(setup, sample(b, 400, 0.1, 1, 0));
    const auto height = [&] {
        const Totals t = sim->totals();
        return t.potential / (t.mass * 9.81);
    };
    const double start = height(), T = 0.3;
    go_to(*sim, T);
    // Velocities before positions: Δt/2 late.
    CHECK(height() - start == Approx(T - 9.81 / 2 * T * (T + *setup.solver.dt)).margin(0.02 * 5e-3));
}

TEST_CASE("what falls never sleeps, however short its rest", "[rest]") {
    Setup setup = floating_setup();
    setup.gravity = {0, -9.81, 0};
    setup.solver.integrator = Integrator::explicit_euler;
    setup.solver.rest_speed = 1, setup.solver.rest_time = 0;
    const auto sim = make_simulation(setup, sample(slab(), 400, 0.1, 1, 0));
    const Totals start = sim->totals();
    for (int step = 0; step < 300; ++step) REQUIRE(sim->step(1).asleep == 0);
    const Totals end = sim->totals();
    CHECK(end.kinetic == Approx(start.potential - end.potential).epsilon(0.01));
}

TEST_CASE("what drifts slower than rest_speed is not held for good", "[rest]") {
    Setup setup = floating_setup();
    setup.solver.integrator = Integrator::explicit_euler;
    setup.solver.rest_time = 0.05;
    Body b = slab();
    b.velocity = {0.01, 0, 0};
    const auto sim = make_simulation(setup, sample(b, 400, 0.1, 1, 0));
    const std::vector<float> before = sim->positions();
    std::size_t asleep = 0;
    while (sim->time() < 0.5) asleep = std::max(asleep, sim->step(1).asleep);
    CHECK(asleep == sim->size());
    // It is awake for rest_time, then asleep until its velocity, half of rest_speed, would have carried it by
    // rest_speed rest_time: a third of the time it moves.
    CHECK(sim->positions()[0] - before[0] == Approx(0.01 * 0.5 / 3).epsilon(0.3));
}

TEST_CASE("on ice a bed that sleeps in part keeps its momentum along it", "[rest]") {
    Setup setup = lying_setup();
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    setup.solver.precision = Precision::twofold;
    setup.colliders[0].friction = 0;
    setup.solver.dt = 1e-3;
    setup.solver.rest_time = 0.02;
    const auto sim = make_simulation(setup, slab_and_ball(2));
    const double start = sim->totals().mass * 2;    // the ball's speed
    std::size_t asleep = 0;
    while (sim->time() < 0.2) asleep = std::max(asleep, sim->step(1).asleep);
    CHECK(asleep > 0);
    CHECK(std::abs(sim->totals().momentum.x()) < 1e-6 * start);
    CHECK(std::abs(sim->totals().momentum.z()) < 1e-6 * start);
}

TEST_CASE("sleep is saved and restored to the same bits, for every number of threads", "[rest]") {
    Setup setup = lying_setup();
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit);
    const auto run = [&](int threads) {
        const int usual = omp_get_max_threads();
        omp_set_num_threads(threads);
        auto sim = make_simulation(setup, slab_and_ball(2));
        const StepReport report = go_to(*sim, 0.2);
        omp_set_num_threads(usual);
        CHECK(report.asleep > 0);
        CHECK(report.asleep < sim->size());
        return sim;
    };
    const auto one = run(1), three = run(3);
    std::stringstream state;
    three->save(state);
    const auto restored = make_simulation(setup, slab_and_ball(2));
    restored->restore(state);
    for (const auto& sim : {one.get(), three.get(), restored.get()}) go_to(*sim, 0.25);
    CHECK(one->rows(true).data == three->rows(true).data);
    CHECK(restored->rows(true).data == three->rows(true).data);
    CHECK(restored->totals().momentum == three->totals().momentum);
}
