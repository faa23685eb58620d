#include "sim/simulation.h"
#include "tests/columns.h"
#include "tests/reference.h"
#include "tests/sanitizers.h"

#include <catch2/catch.hpp>
#include <omp.h>

#include <random>
#include <sstream>

using namespace firn;

namespace {

/// A small ball above a ground and beside a sticky wall, thrown at both: contact and plastic flow within a few steps.
Setup small_setup() {
    Setup s;
    s.h = 0.1;
    s.materials = {Snow{}};
    s.solver = Solver::paper();
    s.solver.precision = Precision::twofold;
    s.solver.dt = 5e-4;
    s.solver.tolerance = 1e-12;
    s.solver.max_iterations = 2000;
    Collider ground, wall, post;
    ground.shape = Plane{{0, 0, 0}, {0, 1, 0}};
    wall.shape = Box{{0.6, 0, 0}, {0.4, 2, 2}};
    wall.contact = ContactLaw::sticky;
    post.shape = Capsule{{-0.1, -0.2, -0.1}, {-0.1, 0.05, -0.1}, 0.08};
    post.velocity = {0.5, 1, 0};
    post.friction = 0.2;
    s.colliders = {ground, wall, post};
    return s;
}

ParticleSet small_ball(int particles_per_cell = 4) {
    Body b;
    b.shape = Sphere{{0.21, 0.17, 0.01}, 0.2};
    b.velocity = {5, -4, 1};
    b.angular_velocity = {3, 10, -5};
    b.particles_per_cell = particles_per_cell;
    return sample(b, 400, 0.1, 7, 0);
}

reference::World world(const Setup& setup, const ParticleSet& start) {
    reference::World w;
    w.h = setup.h, w.gravity = setup.gravity, w.snow = setup.materials[0], w.solver = setup.solver;
    w.colliders = setup.colliders;
    for (std::size_t p = 0; p < start.size(); ++p) {
        w.particles.emplace_back();
        w.particles.back().x = start.x[p], w.particles.back().v = start.v[p], w.particles.back().m = start.m[p];
        w.particles.back().V0 = start.m[p] / setup.materials[0].rho;
    }
    if (setup.solver.initial_volume == InitialVolume::grid) w.set_volumes();
    return w;
}

/// Largest differences between the program and the reference, in units of lengths, speeds and strains here.
struct Distance { double x = 0, v = 0, Fe = 0, Jp = 0, V0 = 0; };
Distance distance(const Simulation& sim, const reference::World& w) {
    const ParticleRows rows = sim.rows(true);
    Distance d;
    for (std::size_t p = 0; p < w.particles.size(); ++p) {
        const reference::Particle& q = w.particles[p];
        const char* axes[] = {"x", "y", "z"};
        for (int a = 0; a < 3; ++a) {
            d.x = std::max(d.x, std::abs(value(rows, p, axes[a]) - q.x(a)));
            d.v = std::max(d.v, std::abs(value(rows, p, std::string("v") + axes[a]) - q.v(a)));
            for (int b = 0; b < 3; ++b)
                d.Fe = std::max(d.Fe, std::abs(value(rows, p, "Fe_" + std::to_string(a) + std::to_string(b)) - q.F_E(a, b)));
        }
        d.Jp = std::max(d.Jp, std::abs(value(rows, p, "Jp") - q.F_P.determinant()));
        d.V0 = std::max(d.V0, std::abs(value(rows, p, "volume") / q.V0 - 1));
    }
    return d;
}

}  // namespace

TEST_CASE("the fast step is the reference step, particle by particle", "[step]") {
    Setup setup = small_setup();
    const auto weights = GENERATE(Weights::cubic, Weights::quadratic);
    const auto transfer = GENERATE(Transfer::flip, Transfer::apic);
    const auto beta = GENERATE(0.0, 0.5, 1.0);
    const Stiff stiff = beta == 1 ? Stiff::all : Stiff::weighted;
    if (stiff == Stiff::weighted) {     // c Δt/h is 0.1 here and grows with hardening
        setup.solver = Solver{};
        setup.solver.precision = Precision::twofold, setup.solver.dt = 5e-4, setup.solver.tolerance = 1e-12;
        setup.solver.max_iterations = 2000, setup.solver.stiff_limit = 0.1;
    }
    setup.solver.weights = weights;
    setup.solver.transfer = transfer;
    setup.solver.integrator = beta == 0 ? Integrator::explicit_euler : Integrator::semi_implicit;
    setup.solver.beta = beta;
    if (transfer == Transfer::apic) setup.materials[0].max_density = 405;   // some of it becomes as dense
    setup.solver.initial_volume = beta == 0.5 ? InitialVolume::sampled : InitialVolume::grid;
    const ParticleSet start = small_ball(beta == 0 ? 4 : 1);
    reference::World w = world(setup, start);
    const auto sim = make_simulation(setup, ParticleSet(start));
    CAPTURE(int(weights), int(transfer), beta, int(stiff), start.size());
    REQUIRE(start.size() > 20);
    double flow = 0, packed = 0;
    for (int step = 0; step < tries(20, 5); ++step) {
        const StepReport report = sim->step(1);
        REQUIRE(report.dt == *setup.solver.dt);
        REQUIRE(report.rejected == 0);
        REQUIRE(report.converged);
        w.step(report.dt);
    }
    for (const reference::Particle& p : w.particles) {
        flow = std::max(flow, std::abs(p.F_P.determinant() - 1));
        packed += p.F_P.determinant() < w.least_J_P() * (1 + 1e-9);
    }
    REQUIRE(flow > 0.01);       // the return mapping had work to do
    REQUIRE((packed > 0) == (transfer == Transfer::apic));
    const Distance d = distance(*sim, w);
    const double bound = beta == 0 ? 1e-10 : 1e-8;
    CHECK(d.x < bound);
    CHECK(d.v < 10 * bound);    // speeds are about 10 m/s
    CHECK(d.Fe < bound);
    CHECK(d.Jp < bound);
    CHECK(d.V0 < 1e-12);
}

TEST_CASE("float follows double until round-off has grown", "[step]") {
    Setup setup = small_setup();
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit);
    setup.solver.precision = Precision::single;
    setup.solver.transfer = GENERATE(Transfer::flip, Transfer::apic);
    setup.solver.weights = GENERATE(Weights::cubic, Weights::quadratic);
    const ParticleSet start = small_ball(setup.solver.integrator == Integrator::explicit_euler ? 4 : 1);
    reference::World w = world(setup, start);
    const auto sim = make_simulation(setup, ParticleSet(start));
    for (int step = 0; step < tries(20, 5); ++step) w.step(sim->step(1).dt);
    // ε = 6e-8: positions round by ε each step; a stress of about E (F − R) by E ε, so a step adds
    // Δt² E ε / (ρ h²) ≈ 1e-7 to F; contact and yield amplify that by ten each. A solve ends at a residual of 4 ε ‖v*‖
    // and its system's condition is 1 + β Δt² ω² < 10, ω the highest frequency of the grid: 40 ε |v| ≈ 2e-5 m/s a
    // step, 4e-4 in twenty, amplified like the rest.
    const Distance d = distance(*sim, w);
    CAPTURE(d.x, d.v, d.Fe, d.Jp, int(setup.solver.integrator));
    CHECK(d.x < 2e-5);
    CHECK(d.v < 2e-2);
    CHECK(d.Fe < 1e-3);
}

TEST_CASE("a ball in free fall falls as Galileo says, and stays as it is", "[step]") {
    Setup setup = small_setup();
    setup.colliders.clear();
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit);
    setup.solver.transfer = GENERATE(Transfer::flip, Transfer::apic);
    Body b;
    b.shape = Sphere{{0, 5, 0}, 0.2};
    b.velocity = {1, 2, 3};
    const ParticleSet start = sample(b, 400, 0.1, 1, 0);
    const auto sim = make_simulation(setup, ParticleSet(start));
    const int steps = 200;
    for (int i = 0; i < steps; ++i) sim->step(1);
    const ParticleRows rows = sim->rows(true);
    const double dt = *setup.solver.dt, t = steps * dt;
    for (std::size_t p = 0; p < start.size(); ++p) {
        // Symplectic Euler: y = y₀ + v₀ t − g Δt² n (n + 1) / 2.
        REQUIRE(value(rows, p, "y") == Approx(start.x[p].y() + 2 * t - 9.81 * dt * dt * steps * (steps + 1) / 2).epsilon(1e-12));
        REQUIRE(value(rows, p, "x") == Approx(start.x[p].x() + t).margin(1e-13));
        REQUIRE(value(rows, p, "vy") == Approx(2 - 9.81 * t).epsilon(1e-12));
        REQUIRE(value(rows, p, "Fe_00") == Approx(1).epsilon(1e-12));
        REQUIRE(value(rows, p, "Jp") == 1);
    }
}

TEST_CASE("without contact, momentum and (APIC) angular momentum are kept to round-off", "[step]") {
    Setup setup = small_setup();
    setup.colliders.clear();
    setup.gravity.setZero();
    setup.solver.transfer = Transfer::apic;
    setup.solver.integrator = Integrator::explicit_euler;
    Body a, b;
    a.shape = Sphere{{0, 0, 0}, 0.2}, a.velocity = {6, 0.5, 0}, a.angular_velocity = {0, 30, 10};
    b.shape = Box{{0.45, 0.1, 0}, {0.3, 0.3, 0.3}}, b.velocity = {-6, 0, 1};
    ParticleSet start = sample(a, 400, 0.1, 1, 0);
    start.append(sample(b, 400, 0.1, 2, 0));
    const auto sim = make_simulation(setup, std::move(start));
    const Totals before = sim->totals();
    for (int i = 0; i < 100; ++i) sim->step(1);
    const Totals after = sim->totals();
    CHECK(after.mass == Approx(before.mass).epsilon(1e-14));
    CHECK((after.momentum - before.momentum).norm() < 1e-12 * before.mass * 6);
    CHECK((after.angular_momentum - before.angular_momentum).norm() < 1e-12 * before.angular_momentum.norm());
    // They did collide, and lost energy.
    CHECK(after.kinetic + after.elastic < 0.9 * before.kinetic);
}

TEST_CASE("plastic flow never makes energy", "[step]") {
    Setup setup = small_setup();
    setup.colliders.resize(2);      // the third moves and does work
    setup.materials[0].max_density = GENERATE(917.0, 405.0);
    setup.solver.dt.reset();
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit);
    const auto sim = make_simulation(setup, small_ball());
    const auto energy = [&] { const Totals t = sim->totals(); return t.kinetic + t.elastic + t.potential; };
    const double start = energy();
    double lowest = start;
    for (double t = 0; t < 0.1;) {
        t += sim->step(1).dt;
        const double now = energy();
        REQUIRE(now < lowest + 1e-3 * start);
        lowest = std::min(lowest, now);
    }
    CHECK(lowest < 0.7 * start);
}

TEST_CASE("explicit and semi-implicit steps agree to first order in dt", "[step]") {
    Setup setup = small_setup();
    setup.colliders.resize(1);
    setup.materials[0].theta_c = 0.5, setup.materials[0].theta_s = 0.5;  // elastic: smooth in time
    setup.solver.transfer = Transfer::apic;
    Body b;
    b.shape = Sphere{{0, 1, 0}, 0.2};
    b.angular_velocity = {0, 5, 0};
    const ParticleSet start = [&] {
        ParticleSet s = sample(b, 400, 0.1, 1, 0);
        for (Mat3d& F : s.Fe) F = Vec3d(1.02, 0.98, 1).asDiagonal();
        return s;
    }();
    const auto positions = [&](Integrator integrator, double dt) {
        Setup s = setup;
        s.solver.integrator = integrator, s.solver.dt = dt;
        const auto sim = make_simulation(s, ParticleSet(start));
        for (double t = 0; t < 0.01 - 1e-9; t += dt) sim->step(dt);
        return sim->rows(false);
    };
    const auto apart = [&](double dt) {
        const ParticleRows a = positions(Integrator::explicit_euler, dt), c = positions(Integrator::semi_implicit, dt);
        double d = 0;
        for (std::size_t p = 0; p < start.size(); ++p) d = std::max(d, std::abs(value(a, p, "x") - value(c, p, "x")));
        return d;
    };
    const double coarse = apart(2.5e-4), fine = apart(1.25e-4);
    CAPTURE(coarse, fine);
    CHECK(fine > 0);
    CHECK(coarse / fine == Approx(2).margin(0.4));
}

TEST_CASE("at ten times the explicit limit beta = 1 stays bounded and explicit steps do not", "[step]") {
    Setup setup = small_setup();
    setup.colliders.clear();
    setup.gravity.setZero();
    setup.materials[0].theta_c = 0.9, setup.materials[0].theta_s = 1e9, setup.materials[0].xi = 0;  // elastic
    setup.solver.dt = 10 * 0.1 / std::sqrt((38888.9 + 2 * 58333.3) / 400);
    setup.solver.tolerance = 1e-6;
    Body b;
    b.shape = Sphere{{0, 1, 0}, 0.2};
    ParticleSet start = sample(b, 400, 0.1, 1, 0);
    for (Mat3d& F : start.Fe) F = Vec3d(1.002, 0.999, 1).asDiagonal();
    const auto energy = [&](Integrator integrator) {
        Setup s = setup;
        s.solver.integrator = integrator;
        const auto sim = make_simulation(s, ParticleSet(start));
        const double before = sim->totals().elastic;
        for (int i = 0; i < 20; ++i) sim->step(1);
        const Totals t = sim->totals();
        return (t.kinetic + t.elastic) / before;
    };
    CHECK(energy(Integrator::semi_implicit) < 1);
    double grown = 0;
    try { grown = energy(Integrator::explicit_euler); } catch (const SimulationError&) { grown = 1e300; }
    CHECK(grown > 1e3);
}

TEST_CASE("the bits do not depend on the number of threads", "[step]") {
    Setup setup = small_setup();
    setup.h = 0.03;
    setup.solver.dt.reset();
    setup.solver.tolerance = 1e-4, setup.solver.max_iterations = 30;
    setup.solver.precision = Precision::single;
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit);
    Body b;
    b.shape = Sphere{{0.21, 0.17, 0.01}, 0.2};
    b.velocity = {5, -4, 1};
    const auto state = [&](int threads) {
        const int usual = omp_get_max_threads();
        omp_set_num_threads(threads);
        const auto sim = make_simulation(setup, sample(b, 400, setup.h, 7, 0));
        for (int i = 0; i < 15; ++i) sim->step(1);
        omp_set_num_threads(usual);
        std::ostringstream out;
        sim->save(out);
        return out.str();
    };
    const std::string one = state(1);
    CHECK(one == state(2));
    CHECK(one == state(5));
}

TEST_CASE("a restored simulation goes on to the same bits", "[step]") {
    Setup setup = small_setup();
    setup.solver.dt.reset();
    setup.solver.transfer = GENERATE(Transfer::flip, Transfer::apic);
    setup.materials.push_back(Snow{.E = 5e4});
    ParticleSet start = small_ball();
    for (std::size_t p = 0; p < start.size(); p += 3) start.material[p] = 1;
    const auto whole = make_simulation(setup, ParticleSet(start));
    for (int i = 0; i < 10; ++i) whole->step(1);
    std::stringstream state;
    whole->save(state);
    const auto resumed = make_simulation(setup, ParticleSet(start));
    resumed->restore(state);
    CHECK(resumed->steps() == 10);
    CHECK(resumed->time() == whole->time());
    for (int i = 0; i < 10; ++i) CHECK(whole->step(1).dt == resumed->step(1).dt);
    CHECK(whole->rows(true).data == resumed->rows(true).data);
}

TEST_CASE("a state of another simulation or a cut one is refused", "[step]") {
    Setup setup = small_setup();
    const auto sim = make_simulation(setup, small_ball());
    std::stringstream state;
    sim->save(state);
    std::stringstream cut(state.str().substr(0, state.str().size() / 2));
    CHECK_THROWS_AS(sim->restore(cut), std::runtime_error);
    setup.solver.precision = Precision::single;
    CHECK_THROWS_AS(make_simulation(setup, small_ball())->restore(state), std::runtime_error);
}

TEST_CASE("steps land on the frame exactly", "[step]") {
    Setup setup = small_setup();
    setup.colliders.clear();
    const auto landed = [&](double frame) {
        const auto sim = make_simulation(setup, small_ball());
        int steps = 0;
        for (double inside = 0;;) {
            const double remaining = frame - inside, dt = sim->step(remaining).dt;
            ++steps;
            REQUIRE(dt <= remaining);
            if (dt >= remaining) return steps;
            inside += dt;
        }
    };
    setup.solver.dt = 1e-3;
    CHECK(landed(0.0205) == 21);            // twenty whole ones and a half
    CHECK(landed(0.02) == 20);              // round-off does not add a sliver
    setup.solver.dt = 1;
    CHECK(landed(0.02) == 1);
    setup.solver.dt.reset();
    CHECK(landed(1e-6) == 1);
}

TEST_CASE("a particle that is nowhere stops the simulation and says which", "[step]") {
    Setup setup = small_setup();
    ParticleSet start = small_ball();
    start.x[5].y() = std::nan("");
    CHECK_THROWS_WITH(make_simulation(setup, std::move(start)), Catch::Contains("particle 5"));
}

TEST_CASE("a step that would turn particles inside out is halved, counted and still lands", "[step]") {
    Setup setup = small_setup();
    setup.colliders.clear();
    setup.materials[0].xi = 0;      // what is packed in one long step would harden out of all proportion
    setup.solver.integrator = Integrator::explicit_euler;
    setup.solver.dt = 0.02;
    ParticleSet start = small_ball();
    for (std::size_t p = 0; p < start.size(); ++p) start.v[p] = -80 * (start.x[p] - Vec3d(0.21, 0.17, 0.01));  // implosion
    const auto sim = make_simulation(setup, std::move(start));
    const StepReport report = sim->step(0.02);
    CHECK(report.rejected > 0);
    CHECK(report.dt == 0.02 / std::pow(2, report.rejected));
    const ParticleRows rows = sim->rows(true);
    for (std::size_t p = 0; p < rows.count; ++p) REQUIRE(value(rows, p, "Jp") > 0);
}
