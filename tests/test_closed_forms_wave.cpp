#include "tests/columns.h"

#include <catch2/catch.hpp>

#include <numbers>

// A wave of finite amplitude whose exact form needs no body force: for ν = 0 and a deformation along one axis
// P = 2μ (F − 1) is linear in F = 1 + ∂u/∂X, so that u = A sin(k X) cos(ω t) with ω = k √(E/ρ) solves
// ρ ∂²u/∂t² = ∂P/∂X however large A is. Particles cross cells in it.

using namespace firn;

namespace {

struct Wave {
    double h = 1.0 / 32;                        ///< [m]; the wave is 1 m long.
    double courant = 0.05;                      ///< c Δt / h
    Weights weights = Weights::cubic;
    Transfer transfer = Transfer::flip;
    Integrator integrator = Integrator::explicit_euler;
    int per_cell = 2;
};

/// Error of the displacement after half a period, root mean square over the middle one of three waves' length
/// (what comes from the ends has not reached it), in units of the amplitude.
double error(const Wave& w) {
    constexpr double k = 2 * std::numbers::pi, A = 0.1 / k, E = 1e5, rho = 400;
    const double c = std::sqrt(E / rho), omega = k * c, seconds = std::numbers::pi / omega;
    Setup setup;
    setup.h = w.h;
    setup.gravity.setZero();
    setup.materials = {{.E = E, .nu = 0, .xi = 0, .theta_c = 0.9, .theta_s = 1e9, .rho = rho}};
    setup.solver.precision = Precision::twofold;
    setup.solver.weights = w.weights, setup.solver.transfer = w.transfer, setup.solver.integrator = w.integrator;
    if (w.integrator == Integrator::semi_implicit) setup.solver.stiff = Stiff::all, setup.solver.beta = 1;
    setup.solver.flip_blend = 1;                // the share of PIC damps more the smaller the step
    setup.solver.dt = w.courant * w.h / c;
    setup.solver.tolerance = 1e-8, setup.solver.max_iterations = 500;
    ParticleSet start;
    std::vector<double> X;
    for (double dX = w.h / w.per_cell, at = dX / 2; at < 3; at += dX) {
        X.push_back(at);
        start.x.push_back({at + A * std::sin(k * at), 0.3 * w.h, 0.3 * w.h});
        start.v.push_back({0, 0, 0});
        start.V0.push_back(dX * w.h * w.h), start.m.push_back(rho * start.V0.back());
        start.Jp.push_back(1), start.material.push_back(0);
        start.Fe.push_back(Vec3d(1 + A * k * std::cos(k * at), 1, 1).asDiagonal());
    }
    const auto sim = make_simulation(setup, std::move(start));
    while (sim->time() < seconds * (1 - 1e-12)) sim->step(seconds - sim->time());
    const ParticleRows rows = sim->rows(false);
    double sum = 0, n = 0;
    for (std::size_t p = 0; p < X.size(); ++p) {
        if (X[p] < 1 || X[p] > 2) continue;
        const double u = A * std::sin(k * X[p]) * std::cos(omega * seconds);
        sum += std::pow(value(rows, p, "x") - X[p] - u, 2), ++n;
    }
    return std::sqrt(sum / n) / A;
}

}  // namespace

TEST_CASE("the error falls with h squared until quadrature flattens it", "[closed_forms]") {
    const OneThread one_thread;
    Wave w;
    w.courant = 0.2;
    w.weights = GENERATE(Weights::cubic, Weights::quadratic);
    const auto error_at = [&](int n) { w.h = 1.0 / n; return error(w); };
    const double coarse = error_at(16), middle = error_at(32), fine = error_at(64);
    CAPTURE(int(w.weights), coarse, middle, fine);
    CHECK(std::log2(coarse / middle) == Approx(1.9).margin(0.15));
    CHECK(std::log2(middle / fine) == Approx(1.85).margin(0.15));
    CHECK(fine < 0.005);
    // Two particles a cell: from here on their sums, not the cells, make the error.
    CHECK(error_at(256) > 1e-3);
}

TEST_CASE("backward Euler's error falls with dt", "[closed_forms]") {
    const OneThread one_thread;
    Wave w;
    w.integrator = Integrator::semi_implicit;
    const auto error_at = [&](double courant) { w.courant = courant; return error(w); };
    const double coarse = error_at(0.8), middle = error_at(0.4), fine = error_at(0.2);
    CAPTURE(coarse, middle, fine);
    CHECK((coarse - middle) / (middle - fine) == Approx(2).margin(0.2));
}

TEST_CASE("APIC smooths once a step: its error grows as dt falls", "[closed_forms]") {
    const OneThread one_thread;
    Wave w;
    w.transfer = Transfer::apic;
    w.h = 1.0 / 64;
    const auto error_at = [&](double courant) { w.courant = courant; return error(w); };
    CHECK(error_at(0.1) / error_at(0.2) == Approx(2).margin(0.2));
}
