#include "sim/simulation.h"
#include "tests/columns.h"
#include "tests/reference.h"
#include "tests/sanitizers.h"

#include <catch2/catch.hpp>

// Where the energy goes, and what bodies feel.

using namespace firn;

namespace {

Setup against_the_ground(Integrator integrator, Transfer transfer) {
    Setup s;
    s.h = 0.1, s.materials = {Snow{}};
    s.solver.precision = Precision::twofold, s.solver.integrator = integrator, s.solver.transfer = transfer;
    s.solver.dt = 5e-4, s.solver.tolerance = 1e-12, s.solver.max_iterations = 2000, s.solver.stiff_limit = 0.1;
    Collider ground, pusher;
    ground.shape = Plane{{0, 0, 0}, {0, 1, 0}};
    pusher.shape = Box{{-0.5, 0, 0}, {0.6, 2, 2}}, pusher.velocity = {2, 0, 0};
    s.colliders = {ground, pusher};
    return s;
}

ParticleSet thrown_ball() {
    Body b;
    b.shape = Sphere{{0.21, 0.17, 0.01}, 0.2}, b.velocity = {1, -4, 0.5}, b.angular_velocity = {3, 10, -5}, b.particles_per_cell = 4;
    return sample(b, 400, 0.1, 7, 0);
}

double moving(const Totals& t) { return t.kinetic + t.elastic; }

}  // namespace

TEST_CASE("the ledger's rows sum up to the change of energy, and plastic flow takes", "[ledger]") {
    const OneThread one_thread;
    const auto integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    const auto transfer = GENERATE(Transfer::flip, Transfer::apic);
    CAPTURE(int(integrator), int(transfer));
    const auto sim = make_simulation(against_the_ground(integrator, transfer), thrown_ball());
    const Totals start = sim->totals();
    Ledger all;
    Vec3d impulse(0, 0, 0);
    double before = moving(start);
    for (int i = 0; i < 60; ++i) {
        const StepReport report = sim->step(1);
        const double now = moving(sim->totals());
        REQUIRE(report.ledger.sum() == Approx(now - before).margin(1e-12 * moving(start)));
        REQUIRE(report.ledger.plastic <= 1e-15 * moving(start));
        before = now, all += report.ledger;
        for (const Exchange& e : report.exchanges) impulse += e.impulse;
    }
    CHECK(all.plastic < -0.01 * moving(start));         // it yielded,
    CHECK(std::abs(all.contact) > 0.01 * moving(start));   // and met the bodies
    // What the bodies got is what the snow lost, and gravity gave.
    const Totals end = sim->totals();
    const Vec3d gained = end.momentum - start.momentum - end.mass * sim->time() * Vec3d(0, -9.81, 0);
    const double limit = integrator == Integrator::newton ? 5e-9 : 1e-9;    // its line search ends at round-off of the energy
    CHECK((gained + impulse).norm() < limit * end.mass);
}

TEST_CASE("each row of the ledger is the reference's", "[ledger]") {
    const OneThread one_thread;
    const auto integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit);
    const Setup setup = against_the_ground(integrator, GENERATE(Transfer::flip, Transfer::apic));
    const ParticleSet start = thrown_ball();
    reference::World w;
    w.h = setup.h, w.snow = setup.materials[0], w.solver = setup.solver, w.colliders = setup.colliders;
    for (std::size_t p = 0; p < start.size(); ++p) {
        reference::Particle q;
        q.x = start.x[p], q.v = start.v[p], q.m = start.m[p], q.V0 = start.m[p] / setup.materials[0].rho;
        w.particles.push_back(q);
    }
    const auto sim = make_simulation(setup, ParticleSet(start));
    Ledger fast, plain;
    for (int i = 0; i < tries(15, 5); ++i) {
        const StepReport report = sim->step(1);
        fast += report.ledger;
        w.step(report.dt);
        plain += w.ledger;
    }
    const double unit = moving(sim->totals());
    CAPTURE(int(integrator), int(setup.solver.transfer));
    CHECK(fast.gravity == Approx(plain.gravity).margin(1e-7 * unit));
    CHECK(fast.to_grid == Approx(plain.to_grid).margin(1e-7 * unit));
    CHECK(fast.integration == Approx(plain.integration).margin(1e-7 * unit));
    CHECK(fast.contact == Approx(plain.contact).margin(1e-7 * unit));
    CHECK(fast.plastic == Approx(plain.plastic).margin(1e-7 * unit));
    CHECK(fast.to_particles == Approx(plain.to_particles).margin(1e-7 * unit));
}

TEST_CASE("the ground bears the weight of snow that lies on it, and a slope its friction", "[ledger]") {
    const OneThread one_thread;
    const double slope = GENERATE(0.0, 20.0) * 3.14159265358979 / 180;
    Setup setup;
    setup.h = 0.025, setup.materials = {Snow{}};
    setup.gravity = 9.81 * Vec3d(std::sin(slope), -std::cos(slope), 0);
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    // What Newton's solve leaves of its residual nobody gives: bodies' impulses are as exact as it is.
    if (setup.solver.integrator == Integrator::newton) setup.solver.tolerance = 1e-4;
    Collider ground;
    ground.shape = Plane{{0, 0, 0}, {0, 1, 0}}, ground.friction = 0.6;
    setup.colliders = {ground};
    Body slab;
    slab.shape = Box{{0, 0.05, 0}, {0.2, 0.1, 0.2}};
    const auto sim = make_simulation(setup, sample(slab, 400, setup.h, 1, 0));
    const double mass = sim->totals().mass;
    Vec3d impulse(0, 0, 0);
    const double begin = 1, end = 1.25;
    while (sim->time() < end - 1e-12) {
        const double to = sim->time() < begin - 1e-12 ? begin : end;
        const StepReport report = sim->step(to - sim->time());
        if (sim->time() > begin + 1e-12) impulse += report.exchanges[0].impulse;
    }
    CAPTURE(slope, int(setup.solver.integrator));
    CHECK((impulse / (end - begin) - mass * setup.gravity).norm() < 1e-3 * mass * 9.81);
}
