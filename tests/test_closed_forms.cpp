#include "tests/columns.h"
#include "tests/report.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include <numbers>

// The program held against solutions that can be written down. scenes/validation/ and docs/validation.md have
// the same at higher resolution.

using namespace firn;

namespace {

constexpr double pi = std::numbers::pi;

/// Snow that never yields nor hardens.
Snow elastic_snow(double E, double nu, double rho = 400) {
    return {.E = E, .nu = nu, .xi = 0, .theta_c = 0.9, .theta_s = 1e9, .rho = rho};
}

Setup exact_setup(double h, const Snow& snow) {
    Setup s;
    s.h = h;
    s.gravity.setZero();
    s.materials = {snow};
    s.solver.precision = Precision::twofold;
    s.solver.integrator = Integrator::explicit_euler;
    s.solver.transfer = Transfer::apic;
    s.solver.weights = Weights::cubic;
    s.solver.initial_volume = InitialVolume::sampled;
    s.solver.tolerance = 1e-10;
    s.solver.max_iterations = 2000;
    return s;
}

/// Particles on a lattice of 2³ a cell.
ParticleSet box(const Vec3d& lower, const Vec3d& upper, double h, double rho = 400) {
    Body b;
    b.shape = Box{(lower + upper) / 2, upper - lower};
    b.sampling = Sampling::lattice;
    return sample(b, rho, h, 1, 0);
}

/// Period of the first longitudinal mode of a bar of n cells, fixed at x = 0: twice the time between two zeros
/// of the mode's velocity.
double bar_period(int n, Weights weights, double nu) {
    const double h = 0.05, L = n * h, E = 1e5, rho = 400, c = std::sqrt(E / rho);
    Setup setup = exact_setup(h, elastic_snow(E, nu, rho));
    setup.solver.weights = weights;
    setup.solver.dt = 0.2 * h / c;
    Collider wall;
    wall.shape = Box{{-1, 0, 0}, {2, 4, 4}};
    wall.contact = ContactLaw::sticky;
    setup.colliders = {wall};
    ParticleSet start = box({0, 0, 0}, {L, 2 * h, 2 * h}, h);
    std::vector<double> mode;
    for (std::size_t p = 0; p < start.size(); ++p) {
        mode.push_back(std::sin(pi * start.x[p].x() / (2 * L)));
        start.v[p].x() = 1e-3 * c * mode[p];
    }
    const auto sim = make_simulation(setup, std::move(start));
    std::vector<double> zeros;
    for (double before = 1; zeros.size() < 2;) {
        const double dt = sim->step(1).dt;
        const std::vector<float> v = sim->velocities();
        double now = 0;
        for (std::size_t p = 0; p < mode.size(); ++p) now += mode[p] * v[3 * p];
        if (now * before < 0) zeros.push_back(sim->time() - dt * now / (now - before));
        before = now;
    }
    return 2 * (zeros[1] - zeros[0]);
}

}  // namespace

TEST_CASE("an elastic bar swings with the period 4 L sqrt(rho / E)", "[closed_forms]") {
    const OneThread one_thread;
    const auto weights = GENERATE(Weights::cubic, Weights::quadratic);
    const auto error = [&](int n) { return bar_period(n, weights, 0) / (4 * n * 0.05 * std::sqrt(400 / 1e5)) - 1; };
    const double coarse = error(16), fine = error(32);
    CAPTURE(int(weights));
    CAPTURE(coarse, fine);
    // The ends add about half a cell to the length: an error of first order, which two grids take away.
    CHECK(std::abs(fine) < 0.015);
    CHECK(coarse / fine == Approx(2).margin(0.15));
    CHECK(std::abs(2 * fine - coarse) < 1e-3);
}

TEST_CASE("a ball spins with its angular momentum over its moment of inertia, and keeps its shape", "[closed_forms]") {
    const OneThread one_thread;
    const double h = 0.1, omega = 2;
    Setup setup = exact_setup(h, elastic_snow(1.4e5, 0.2));
    Body b;
    b.shape = Sphere{{0, 0, 0}, 0.2};
    b.angular_velocity = {0, omega, 0};
    const ParticleSet start = sample(b, 400, h, 1, 0);
    const auto sim = make_simulation(setup, ParticleSet(start));
    const Totals before = sim->totals();
    // A particle under APIC is a body of its own, with the moment D about each axis of the plane.
    const double D = h * h / 3;
    Mat3d xX = Mat3d::Zero(), XX = Mat3d::Zero();
    double inertia = 0;
    for (std::size_t p = 0; p < start.size(); ++p) {
        const Vec3d& X = start.x[p];
        inertia += start.m[p] * (X.x() * X.x() + X.z() * X.z() + 2 * D);
    }
    const double period = 2 * pi * inertia / before.angular_momentum.y();
    while (sim->time() < period - 1e-12) sim->step(period - sim->time());
    // Best rotation and stretch of the whole: Σ m x Xᵀ (Σ m X Xᵀ)⁻¹ = R S.
    const ParticleRows rows = sim->rows(true);
    for (std::size_t p = 0; p < rows.count; ++p) {
        xX += start.m[p] * position(rows, p) * start.x[p].transpose();
        XX += start.m[p] * start.x[p] * start.x[p].transpose();
    }
    const Elastic<double> whole = elastic(Mat3d(xX * XX.inverse()));
    const double turned = std::atan2(whole.R(0, 2), whole.R(0, 0));     // beyond the whole turn
    const Totals after = sim->totals();
    CAPTURE(turned, whole.S);
    // Centrifugal stretch is ρ ω² R² / E ≈ 5e-4 at most, and slows the spin by twice that.
    CHECK(std::abs(turned) < 2 * pi * 2e-3);
    CHECK((whole.S - Mat3d::Identity()).norm() < 2e-3);
    CHECK((after.angular_momentum - before.angular_momentum).norm() < 1e-12 * before.angular_momentum.norm());
    CHECK(after.momentum.norm() < 1e-13 * after.mass * omega);
}

TEST_CASE("no integrator makes momentum", "[closed_forms]") {
    const OneThread one_thread;
    Setup setup = exact_setup(0.1, Snow{});
    setup.solver.integrator = GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton);
    setup.solver.transfer = GENERATE(Transfer::flip, Transfer::apic);
    setup.solver.max_iterations = 3;    // momentum must not hang on the solve
    setup.solver.dt = 1e-3;
    Body a, b;
    a.shape = Sphere{{0, 0, 0}, 0.2}, a.velocity = {6, 0.5, 0};
    b.shape = Sphere{{0.45, 0.1, 0}, 0.2}, b.velocity = {-6, 0, 1};
    ParticleSet start = sample(a, 400, 0.1, 1, 0);
    start.append(sample(b, 400, 0.1, 2, 0));
    const auto sim = make_simulation(setup, std::move(start));
    const Totals before = sim->totals();
    for (int i = 0; i < 25; ++i) sim->step(1);
    const Totals after = sim->totals();
    CHECK((after.momentum - before.momentum).norm() < 1e-12 * before.mass * 6);
    CHECK(after.kinetic + after.elastic < 0.9 * before.kinetic);
}

namespace {

/// A block on an incline. Axes of the slope: down along it, off it, across it.
struct Incline {
    Integrator integrator = Integrator::explicit_euler;
    double friction = 0.3;
    Vec3d velocity{0, 0, 0}, slope_velocity{0, 0, 0};   ///< of block and slope [m/s].
    bool with_grid = true;          ///< the slope lies along the grid and gravity is tilted; else they are turned against it.
    double E = 1e6, dt = 2e-3;      ///< [Pa], [s]; an explicit Δt is less.
    static constexpr double angle = 30 * pi / 180, g = 9.81;
    /// [s]; an implicit step damps what rocks.
    double seconds() const { return integrator == Integrator::explicit_euler ? 0.7 : 0.3; }
    double settled() const { return seconds() / 2; }
};

/// What the block gained from `settled()` to the end [m/s].
Vec3d gain(const Incline& a) {
    Setup setup = exact_setup(0.1, elastic_snow(a.E, 0.2));
    setup.solver.integrator = a.integrator;
    setup.solver.max_dt = a.dt;
    setup.solver.tolerance = 1e-5;
    Mat3d turn = Mat3d::Identity();
    if (!a.with_grid) turn = Eigen::AngleAxisd(-a.angle, Vec3d::UnitZ()).toRotationMatrix();
    setup.gravity = a.g * turn * Vec3d(std::sin(a.angle), -std::cos(a.angle), 0);
    Collider slope;
    slope.friction = a.friction;
    slope.shape = Plane{{0, 0, 0}, turn.col(1)};
    slope.velocity = turn * a.slope_velocity;
    setup.colliders = {slope};
    ParticleSet start = box({0, 0, 0}, {0.6, 0.1, 0.2}, setup.h);
    for (Vec3d& x : start.x) x = turn * x;
    for (Vec3d& v : start.v) v = turn * a.velocity;
    const auto sim = make_simulation(setup, std::move(start));
    Vec3d at[2];
    for (const int k : {0, 1}) {
        const double until = k == 0 ? a.settled() : a.seconds();
        while (sim->time() < until - 1e-12) sim->step(until - sim->time());
        at[k] = turn.transpose() * sim->totals().momentum / sim->totals().mass;
    }
    return at[1] - at[0];
}

/// The same for a point: u' = g sin θ − μ g cos θ w/‖w‖ with w = u − slope's, or u = slope's where friction can hold it.
Vec3d exact_gain(const Incline& a) {
    constexpr int steps = 70000;
    const double dt = a.seconds() / steps, held = a.friction * a.g * std::cos(a.angle) * dt;
    Vec3d u = a.velocity, settled = u;
    for (int i = 0; i < steps; ++i) {
        if (i == steps / 2) settled = u;
        const Vec3d w = u + Vec3d(a.g * std::sin(a.angle) * dt, 0, 0) - a.slope_velocity;
        u = a.slope_velocity + std::max(0.0, 1 - held / w.norm()) * w;
    }
    return u - settled;
}

/// Holds the two against each other. What the block gains off the slope, as it rocks on its springs, came through the
/// contact as well: friction has μ times that.
void check(const Incline& a) {
    const Vec3d measured = gain(a), exact = exact_gain(a);
    CAPTURE(int(a.integrator), a.friction, a.velocity.transpose(), a.slope_velocity.transpose(), measured.transpose(), exact.transpose());
    const bool slides = exact.norm() > 0.02 * a.g * (a.seconds() - a.settled());
    const Vec3d along = measured + (slides ? a.friction : 0) * measured.y() * Vec3d::UnitX() - measured.y() * Vec3d::UnitY();
    CHECK((along - exact).norm() < 1e-3 * (slides ? exact.norm() : a.g * (a.seconds() - a.settled())));
}

Integrator any_integrator() { return GENERATE(Integrator::explicit_euler, Integrator::semi_implicit, Integrator::newton); }

}  // namespace

TEST_CASE("a block on an incline slides with g (sin - mu cos), or stays", "[closed_forms]") {
    const OneThread one_thread;
    Incline a;
    a.integrator = any_integrator();
    a.with_grid = GENERATE(true, false);
    const bool newton = a.integrator == Integrator::newton;     // its solves take long
    for (const double friction : newton ? std::vector{0.5, 0.7} : std::vector{0.0, 0.3, 0.5, 0.7}) a.friction = friction, check(a);  // tan 30° = 0.577
}

TEST_CASE("friction acts against the motion on the slope, whoever moves", "[closed_forms]") {
    const OneThread one_thread;
    Incline a;
    a.integrator = any_integrator();
    for (const double friction : {0.3, 0.7}) {
        if (friction > 0.5 && a.integrator == Integrator::newton) continue;     // its solves take long
        a.friction = friction;
        for (const Vec3d& v : {Vec3d(1, 0, 0), Vec3d(-8, 0, 0)}) a.velocity = v, check(a);      // down, and up all the time
        a.velocity.setZero();
        for (const Vec3d& v : {Vec3d(8, 0, 0), Vec3d(-8, 0, 0)}) a.slope_velocity = v, check(a);
        a.slope_velocity.setZero();
    }
    a.friction = 0.3, a.slope_velocity = {0, 0, 8}, check(a);
}

TEST_CASE("friction is right in implicit steps of ten cells' sound", "[closed_forms]") {
    const OneThread one_thread;
    Incline a;
    a.E = 1e8;
    a.integrator = Integrator::newton, a.friction = 0.6, check(a);
    a.integrator = Integrator::semi_implicit, a.with_grid = false;
    for (const double friction : {0.3, 0.55, 0.6}) a.friction = friction, check(a);
}
