#include "tests/columns.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace firn;

namespace {

Setup frictionless_wall(double h, const Snow& snow, double place) {
    Setup s;
    s.h = h;
    s.gravity.setZero();
    s.materials = {snow};
    s.solver.precision = Precision::twofold;
    s.solver.integrator = Integrator::explicit_euler;
    s.solver.weights = Weights::quadratic;
    s.solver.initial_volume = InitialVolume::sampled;
    Collider wall;
    wall.friction = 0;
    wall.shape = Plane{{place, 0, 0}, {1, 0, 0}};
    s.colliders = {wall};
    return s;
}

/// FLIP that forgets a twentieth in a millisecond, whatever Δt is.
double blend(double dt) { return std::pow(0.95, dt / 1e-3); }

/// Speed with which an elastic bar of 0.8 m leaves a wall, over the one with which it came. The wall's face lies
/// `place` cells from a node; Δt is x h/c.
double restitution(double h, double x, double place) {
    const double L = 0.8, E = 1e7, rho = 400, speed = 2, c = std::sqrt(E / rho), start = 3 * h;
    Setup setup = frictionless_wall(h, {.E = E, .nu = 0, .xi = 0, .theta_c = 0.9, .theta_s = 1e3, .rho = rho}, place * h);
    setup.solver.dt = x * h / c, setup.solver.flip_blend = blend(*setup.solver.dt);
    Body bar;
    bar.shape = Box{{start + L / 2, h / 2, h / 2}, {L, h, h}};
    bar.sampling = Sampling::lattice;
    bar.velocity = {-speed, 0, 0};
    const auto sim = make_simulation(setup, sample(bar, rho, h, 1, 0));
    const double until = (start - place * h) / speed + 2 * L / c + 0.01;  // two ways of the wave through the bar, and some more
    while (sim->time() < until) sim->step(until - sim->time());
    const Totals t = sim->totals();
    return t.momentum.x() / (t.mass * speed);
}

}  // namespace

TEST_CASE("an elastic bar leaves a wall as fast as it came, at every dt, h and place of the wall in the grid", "[bounce]") {
    const OneThread one_thread;
    double place = 0;
    for (const double h : {0.05, 0.025})
        for (const double x : {0.7, 0.5, 0.25, 0.1}) {      // free surfaces are unstable from 0.8 on
            CAPTURE(h, x, place);
            CHECK(restitution(h, x, place) == Approx(1).margin(0.02));
            place = std::fmod(place + 0.3, 1);
        }
}

TEST_CASE("one particle of snow does not pass a wall, and gains nothing there", "[bounce]") {
    const double h = 0.1;
    Setup setup = frictionless_wall(h, Snow{}, 0);
    setup.solver.dt = GENERATE(1e-3, 1e-4), setup.solver.flip_blend = blend(*setup.solver.dt);
    setup.solver.node_contact = GENERATE(NodeContact::inelastic, NodeContact::elastic);
    const double speed = GENERATE(0.5, 5.0, 20.0);
    CAPTURE(*setup.solver.dt, int(setup.solver.node_contact), speed);
    ParticleSet one;
    one.x = {{0.25, 0.03, 0.01}}, one.v = {{-speed, 0, 0}}, one.m = {0.05}, one.V0 = {0}, one.Jp = {1};
    one.Fe = {Mat3d::Identity()}, one.material = {0};
    const auto sim = make_simulation(setup, std::move(one));
    double energy = sim->totals().kinetic * (1 + 1e-9);
    for (double t = 0; t < 0.5 / speed;) {
        t += sim->step(1).dt;
        const Totals now = sim->totals();
        REQUIRE(sim->positions()[0] >= -speed * *setup.solver.dt);
        REQUIRE(now.kinetic + now.elastic < energy + 1e-3 * 0.05 * speed * speed);
    }
}

TEST_CASE("a body that moves pushes snow and does not hold what leaves it", "[bounce]") {
    const OneThread one_thread;
    Setup setup;
    setup.h = 0.04;
    setup.gravity.setZero();
    setup.materials = {{.E = 1e5, .theta_c = 2e-2, .theta_s = 5e-3, .rho = 300}};
    setup.solver.precision = Precision::twofold;
    setup.solver.node_contact = GENERATE(NodeContact::elastic, NodeContact::inelastic);
    Collider plough;
    plough.shape = Box{{-0.4, 0, 0}, {0.2, 1, 1}}, plough.velocity = {4, 0, 0}, plough.friction = 0;
    setup.colliders = {plough};
    Body block;
    block.shape = Box{{0, 0, 0}, {0.5, 0.2, 0.2}};
    const auto sim = make_simulation(setup, sample(block, 300, setup.h, 1, 0));
    double pushed = 0, pulled = 0;
    while (sim->time() < 0.15) {
        const double impulse = -sim->step(0.15 - sim->time()).exchanges[0].impulse.x();
        (impulse > 0 ? pushed : pulled) += impulse;
    }
    CAPTURE(int(setup.solver.node_contact), pushed, pulled);
    CHECK(pushed > 20);                                 // 6 kg at 4 m/s, and some rebound
    CHECK(-pulled < 1e-3 * pushed);
}
