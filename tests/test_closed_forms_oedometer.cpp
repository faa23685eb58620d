#include "tests/columns.h"

#include <catch2/catch.hpp>

// A laterally fixed column under its own weight. Where it yields, F_E = 1 − θ_c along the column, and
// P = 2μ₀ (s − 1) + λ₀ (s − 1) = −3888.9 Pa at the defaults, hardened by exp(ξ (1 − J_P)); per area of the
// undeformed column that is P / J_P, which carries the weight ρ₀ g Z of what lies above. Where it is as dense as it can be,
// F_E is k (1 − θ_c) along it and min(1, k (1 + θ_s)) across, and the Cauchy stress τ / (J_E J_P) carries that weight.

using namespace firn;

namespace {

/// J_P under ρ₀ g Z, by bisection.
double exact_Jp(double Z, double g, const Snow& s = {}) {
    const SnowModel<double> m = model(s);
    const double yield = (2 * m.mu0 + m.lambda0) * s.theta_c;
    double low = 0.1, high = 1;
    for (int i = 0; i < 100; ++i) {
        const double Jp = (low + high) / 2;
        (yield * std::exp(s.xi * (1 - Jp)) / Jp > s.rho * g * Z ? low : high) = Jp;
    }
    return std::max(high, m.Jp_min);
}

/// det F_E there, by bisection of k.
double exact_Je(double Z, double g, const Snow& s) {
    const SnowModel<double> m = model(s);
    const Lame<double> lame = hardened(m, m.Jp_min);
    double low = 0.7, high = 1, J = 1;
    for (int i = 0; i < 100; ++i) {
        const double k = (low + high) / 2, along = k * m.low, across = std::min(1.0, k * m.high);
        J = along * across * across;
        const double tau = 2 * lame.mu * along * (along - 1) + lame.lambda * (J - 1) * J;
        (-tau / (J * m.Jp_min) > s.rho * g * Z ? low : high) = k;
    }
    return J;
}

}  // namespace

TEST_CASE("a laterally fixed column compacts under its weight as the material says", "[closed_forms]") {
    const OneThread one_thread;
    CHECK(exact_Jp(2, 9.81) == Approx(0.936).margin(5e-4));
    CHECK(exact_Jp(5, 9.81) == Approx(0.854).margin(5e-4));
    CHECK(exact_Jp(10, 9.81) == Approx(0.792).margin(5e-4));
    const double h = 0.5, height = 11, g = 9.81;
    Setup setup;
    setup.h = h;
    Snow snow;
    snow.max_density = GENERATE(917.0, 450.0);      // 450: below 3.4 m
    setup.materials = {snow};
    setup.solver.weights = Weights::quadratic;
    setup.solver.precision = Precision::twofold;
    setup.solver.integrator = Integrator::semi_implicit;
    setup.solver.initial_volume = InitialVolume::sampled;
    setup.solver.flip_blend = 0;        // damps, so that loading is nearly static
    setup.solver.dt = 1e-2;
    setup.solver.tolerance = 1e-3;
    for (const Vec3d& n : {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 0, 1), Vec3d(0, 0, -1), Vec3d(0, 1, 0)}) {
        Collider wall;
        wall.shape = Plane{n.y() > 0 ? Vec3d::Zero().eval() : Vec3d(-h / 2 * n), n};
        wall.friction = 0;
        setup.colliders.push_back(wall);
    }
    Body column;
    column.shape = Box{{0, height / 2, 0}, {h, height, h}};
    column.sampling = Sampling::lattice;
    ParticleSet state = sample(column, 400, h, 1, 0);
    std::vector<double> depth;
    for (const Vec3d& x : state.x) depth.push_back(height - x.y());
    constexpr int stages = 10;          // of gravity, half a second each
    for (int stage = 1; stage <= stages; ++stage) {
        setup.gravity = {0, -g * stage / stages, 0};
        const auto sim = make_simulation(setup, std::move(state));
        for (int i = 0; i < 50; ++i) sim->step(1);
        state = start_from(sim->rows(true));
    }
    for (const double Z : {0.5, 2.0, 5.0, 10.0}) {
        double Jp = 0, Je = 0, n = 0;
        for (std::size_t p = 0; p < depth.size(); ++p)
            if (std::abs(depth[p] - Z) < h / 2) Jp += state.Jp[p], Je += determinant(state.Fe[p]), ++n;
        CAPTURE(Z, snow.max_density, Jp / n, Je / n, n);
        CHECK(Jp / n == Approx(exact_Jp(Z, g, snow)).epsilon(0.03));
        if (Z > 3.4 && snow.max_density == 450) CHECK(Je / n == Approx(exact_Je(Z, g, snow)).epsilon(0.015));
    }
}
