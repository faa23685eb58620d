#include "sim/simulation.h"
#include "sim/stiffness.h"
#include "tests/columns.h"
#include "tests/sanitizers.h"

#include <catch2/catch.hpp>

#include <random>

// The default step: each particle as implicit as it must be. Stability at every stiffness, rest, and what it keeps.

using namespace firn;

namespace {

Snow elastic_snow(double E, double nu, double rho = 400) { return {.E = E, .nu = nu, .xi = 0, .theta_c = 0.9, .theta_s = 1e9, .rho = rho}; }

double wave_speed(const Snow& snow) {
    const Lame<double> k = hardened(model(snow), 1.0);
    return std::sqrt((k.lambda + 2 * k.mu) / snow.rho);
}

Setup weightless(double h, const std::vector<Snow>& materials) {
    Setup s;
    s.h = h, s.gravity.setZero(), s.materials = materials;
    return s;
}

ParticleSet filled(const Shape& shape, double h, double per_cell = 8, Sampling sampling = Sampling::poisson_disk, double rho = 400) {
    Body b;
    b.shape = shape, b.particles_per_cell = per_cell, b.sampling = sampling;
    return sample(b, rho, h, 1, 0);
}

void shake(ParticleSet& start, double speed) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, speed / std::sqrt(3.0));
    for (Vec3d& v : start.v) v += Vec3d(normal(random), normal(random), normal(random));
}

double moving(const Simulation& sim) {
    const Totals t = sim.totals();
    return t.kinetic + t.elastic;
}

/// Steps of dt; the largest K + Ψ on the way over the first. Of a motion that keeps its energy it swings by ω Δt/2, since
/// velocities are of the steps' middles.
double growth(const Setup& setup, ParticleSet&& start, double dt, int steps) {
    Setup s = setup;
    s.solver.dt = dt;
    const auto sim = make_simulation(s, std::move(start));
    const double first = moving(*sim);
    double most = first;
    for (int i = 0; i < steps; ++i) {
        const StepReport report = sim->step(1);
        REQUIRE(report.converged);
        if (i % 10 == 9) most = std::max(most, moving(*sim));
    }
    return most / first;
}

Collider plane(const Vec3d& normal, double friction = 0, const Vec3d& point = {0, 0, 0}) {
    Collider c;
    c.shape = Plane{point, normal};
    c.friction = friction;
    return c;
}

}  // namespace

TEST_CASE("an elastic ball makes no energy at any c dt/h, crowded or sparse", "[implicit]") {
    const OneThread one_thread;
    const double h = 0.05, x = GENERATE(0.4, 0.6, 0.8, 1.0, 1.25, 2.0, 5.0, 15.0);
    const auto [per_cell, sampling] = GENERATE(std::pair(0.5, Sampling::random), std::pair(8.0, Sampling::poisson_disk),
                                               std::pair(27.0, Sampling::lattice));
    const Snow snow = elastic_snow(1e6, 0.2);
    ParticleSet ball = filled(Sphere{{0, 0, 0}, 0.15}, h, per_cell, sampling);
    shake(ball, 0.1);
    CAPTURE(x, per_cell);
    CHECK(growth(weightless(h, {snow}), std::move(ball), x * h / wave_speed(snow), 300) < 1.2);
}

TEST_CASE("a bar that swings, a pressed block, and stiff heavy snow on soft light snow make no energy", "[implicit]") {
    const OneThread one_thread;
    const double h = 0.05, x = GENERATE(0.44, 1.0, 1.25, 3.0);
    CAPTURE(x);
    const Snow snow = elastic_snow(1e6, 0);
    const double c = wave_speed(snow);
    ParticleSet bar = filled(Box{{0, 0, 0}, {0.8, 0.1, 0.1}}, h, 8, Sampling::lattice);
    for (std::size_t p = 0; p < bar.size(); ++p) bar.v[p].x() = 0.01 * std::sin(4 * bar.x[p].x());
    CHECK(growth(weightless(h, {snow}), std::move(bar), x * h / c, 1000) < 1.2);

    Setup pressed = weightless(h, {snow});
    pressed.colliders = {plane({0, 1, 0})};
    ParticleSet block = filled(Box{{0, 0.1, 0}, {0.2, 0.2, 0.2}}, h);
    for (Mat3d& F : block.Fe) F = Vec3d(1, 0.99, 1).asDiagonal();
    CHECK(growth(pressed, std::move(block), x * h / c, 500) < 1.2);

    const Snow soft = elastic_snow(1e4, 0.2, 100);
    Setup stacked = weightless(h, {soft, snow});
    ParticleSet below = filled(Box{{0, 0.1, 0}, {0.2, 0.2, 0.2}}, h, 8, Sampling::poisson_disk, 100);
    ParticleSet above = filled(Box{{0, 0.3, 0}, {0.2, 0.2, 0.2}}, h);
    for (auto& m : above.material) m = 1;
    below.append(above);
    shake(below, 0.01);
    CHECK(growth(stacked, std::move(below), x * h / c, 500) < 1.2);
}

TEST_CASE("packed snow that trembles comes to rest at every c dt/h, and is packed as before", "[implicit]") {
    const OneThread one_thread;
    const double h = 0.05, x = GENERATE(0.4, 0.8, 1.0, 1.25, 5.0), per_cell = GENERATE(0.5, 8.0);
    ParticleSet ball = filled(Sphere{{0, 0, 0}, 0.15}, h, per_cell, Sampling::random);
    for (double& Jp : ball.Jp) Jp = 0.85;
    shake(ball, 0.01);
    Setup setup = weightless(h, {Snow{}});
    setup.solver.dt = x * h / (wave_speed(Snow{}) * std::exp(10 * 0.15 / 2));
    const auto sim = make_simulation(setup, std::move(ball));
    const double first = moving(*sim);
    for (int i = 0; i < 200; ++i) REQUIRE(sim->step(1).converged);
    CAPTURE(x, per_cell);
    CHECK(moving(*sim) < first);
    const ParticleRows rows = sim->rows(true);
    for (std::size_t p = 0; p < rows.count; ++p) REQUIRE(value(rows, p, "Jp") == Approx(0.85).margin(2e-3));
}

TEST_CASE("snow lies still: packed, loose and unevenly packed", "[implicit]") {
    const OneThread one_thread;
    const double h = 0.025;
    const std::string kind = GENERATE("loose", "packed", "uneven");
    ParticleSet bed = filled(Box{{0, 0.075, 0}, {0.2, 0.15, 0.2}}, h);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uneven(0.7, 1.2);
    for (double& Jp : bed.Jp) Jp = kind == "loose" ? 1 : kind == "packed" ? 0.85 : uneven(random);
    Setup setup;
    setup.h = h, setup.materials = {Snow{}};
    setup.colliders = {plane({0, 1, 0}, 0.4), plane({1, 0, 0}, 0, {-0.1, 0, 0}), plane({-1, 0, 0}, 0, {0.1, 0, 0}),
                       plane({0, 0, 1}, 0, {0, 0, -0.1}), plane({0, 0, -1}, 0, {0, 0, 0.1})};
    const auto sim = make_simulation(setup, std::move(bed));
    CAPTURE(kind);
    double fastest = 0;
    while (sim->time() < 1) {
        const StepReport report = sim->step(1 - sim->time());
        REQUIRE(report.converged);
        REQUIRE(report.rejected == 0);
        const Totals t = sim->totals();
        if (sim->time() > 0.5) fastest = std::max(fastest, std::sqrt(2 * t.kinetic / t.mass));
    }
    CHECK(fastest < 5e-5);      // m/s
}

TEST_CASE("what falls freely is not strained by the step", "[implicit]") {
    const OneThread one_thread;
    Setup setup;
    setup.h = 0.03, setup.materials = {Snow{}};
    ParticleSet ball = filled(Sphere{{0, 0, 0}, 0.1}, setup.h);
    for (std::size_t p = 0; p < ball.size(); ++p) ball.v[p] = {3, 1, 0}, ball.Jp[p] = p % 2 == 0 ? 0.8 : 1;
    const auto sim = make_simulation(setup, std::move(ball));
    while (sim->time() < 1) REQUIRE(sim->step(1 - sim->time()).converged);
    const ParticleRows rows = sim->rows(true);
    for (std::size_t p = 0; p < rows.count; ++p)
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b)
                REQUIRE(std::abs(value(rows, p, "Fe_" + std::to_string(a) + std::to_string(b)) - (a == b)) < 1e-5);
}

TEST_CASE("each piece of snow keeps its momentum, whatever the tolerance and whoever touches a floor", "[implicit]") {
    const OneThread one_thread;
    Setup setup;
    setup.h = 0.05, setup.gravity.setZero(), setup.materials = {Snow{}};
    setup.solver.precision = Precision::twofold, setup.solver.dt = 1e-3;
    setup.solver.integrator = GENERATE(Integrator::semi_implicit, Integrator::newton);
    setup.solver.tolerance = GENERATE(0.3, 1e-2);
    setup.solver.max_iterations = 3;
    setup.colliders = {plane({0, 1, 0}, 0, {0, -1, 0})};
    setup.colliders[0].contact = ContactLaw::sticky;
    ParticleSet start = filled(Sphere{{0, 0, 0}, 0.1}, setup.h), other = filled(Sphere{{0.19, 0.05, 0}, 0.1}, setup.h);
    for (Vec3d& v : start.v) v = {2, 0, 0};
    for (Vec3d& v : other.v) v = {-2, 0, 0};
    start.append(other);
    const std::size_t pair = start.size();
    ParticleSet lying = filled(Box{{0, -0.9, 0}, {0.4, 0.2, 0.4}}, setup.h);
    start.append(lying);
    for (double& Jp : start.Jp) Jp = 0.8;
    const auto sim = make_simulation(setup, std::move(start));
    for (int i = 0; i < 50; ++i) sim->step(1);
    const ParticleRows rows = sim->rows(true);
    Vec3d momentum(0, 0, 0);
    double most = 0;
    for (std::size_t p = 0; p < pair; ++p) {
        const Vec3d v(value(rows, p, "vx"), value(rows, p, "vy"), value(rows, p, "vz"));
        momentum += value(rows, p, "mass") * v, most += value(rows, p, "mass") * v.norm();
    }
    CAPTURE(int(setup.solver.integrator), setup.solver.tolerance);
    CHECK(momentum.norm() < 1e-12 * 4 * most);
}

TEST_CASE("two balls that meet off centre keep their angular momentum", "[implicit]") {
    const OneThread one_thread;
    const auto lost = [](double tolerance) {
        Setup setup = weightless(0.04, {Snow{}});
        setup.solver.transfer = Transfer::apic, setup.solver.tolerance = tolerance;
        ParticleSet start = filled(Sphere{{-0.13, 0.05, 0}, 0.12}, setup.h), other = filled(Sphere{{0.13, -0.05, 0}, 0.12}, setup.h);
        for (Vec3d& v : start.v) v = {5, 0, 0};
        for (Vec3d& v : other.v) v = {-5, 0, 0};
        start.append(other);
        const auto sim = make_simulation(setup, std::move(start));
        const Vec3d before = sim->totals().angular_momentum;
        while (sim->time() < 0.1) sim->step(0.1 - sim->time());
        return (sim->totals().angular_momentum - before).norm() / before.norm();
    };
    CHECK(lost(1e-2) < 3e-3);
    CHECK(lost(1e-4) <= lost(1e-2));
}

TEST_CASE("a packed ball that spins freely keeps its spin as with explicit steps", "[implicit]") {
    const OneThread one_thread;
    const Transfer transfer = GENERATE(Transfer::flip, Transfer::apic);
    const auto kept = [&](Integrator integrator, double max_dt) {
        Setup setup = weightless(0.03, {Snow{}});
        setup.solver.integrator = integrator, setup.solver.transfer = transfer, setup.solver.max_dt = max_dt;
        Body b;
        b.shape = Sphere{{0, 0, 0}, 0.24}, b.angular_velocity = {0, 0, 10};
        ParticleSet ball = sample(b, 400, setup.h, 1, 0);
        for (double& Jp : ball.Jp) Jp = 0.85;
        const auto sim = make_simulation(setup, std::move(ball));
        const double before = sim->totals().angular_momentum.z();
        while (sim->time() < 0.2) sim->step(0.2 - sim->time());
        return sim->totals().angular_momentum.z() / before;
    };
    const double explicit_steps = kept(Integrator::explicit_euler, 1e-3), own = kept(Integrator::semi_implicit, 2e-3);
    CAPTURE(int(transfer), explicit_steps, own);
    CHECK(own > 0.99 * explicit_steps);
    if (transfer == Transfer::apic) CHECK(own > 0.99);
}

TEST_CASE("damping acts by the second: a quarter and a sixteenth of the step keep the same spin", "[implicit]") {
    const OneThread one_thread;
    const auto kept = [](double dt) {
        Setup setup = weightless(0.1, {elastic_snow(2e4, 0.2)});      // soft: FLIP's own noise is small
        setup.solver.integrator = Integrator::explicit_euler, setup.solver.dt = dt;
        Body b;
        b.shape = Sphere{{0, 0, 0}, 0.4}, b.angular_velocity = {0, 1, 0};
        const auto sim = make_simulation(setup, sample(b, 400, setup.h, 1, 0));
        const double before = sim->totals().angular_momentum.y();
        while (sim->time() < 0.2 - 1e-9) sim->step(0.2 - sim->time());
        return sim->totals().angular_momentum.y() / before;
    };
    const double quarter = kept(2.5e-4), sixteenth = kept(6.25e-5);     // of Δt = 1 ms
    CAPTURE(quarter, sixteenth);
    CHECK(quarter < 0.95);      // it does damp
    CHECK(quarter == Approx(sixteenth).epsilon(0.02));
}

TEST_CASE("a particle gets no kick where it becomes implicit", "[implicit]") {
    const double limit2 = 0.45 * 0.45;
    CHECK(implicit_weight(limit2 * (1 - 1e-9), limit2) == 0);
    CHECK(implicit_weight(limit2 * (1 + 1e-9), limit2) == Approx(0).margin(1e-8));
    CHECK(implicit_weight(1e9, limit2) == Approx(1));
    for (double x2 = 0.01; x2 < 100; x2 *= 1.1)     // what is left explicit is stable
        CHECK((1 - implicit_weight(x2, limit2)) * x2 <= limit2 * (1 + 1e-12));
}
