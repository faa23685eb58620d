#pragma once
#include "sim/implicit.h"
#include "sim/linear_system.h"
#include "sim/potential.h"
#include "sim/rest.h"

#include <limits>

namespace firn {

// The fully implicit step (Gast, Schroeder, Stomakhin, Jiang, Teran 2015): vⁿ⁺¹ minimises
//
//   Π(v) = ½ ‖v − v̂‖²_M + Φ(x + Δt v),      ∂Π/∂v = M (v − v̂) − Δt f(x + Δt v),      v̂ = v + Δt g
//
// (the forces of snow at rest do not change, and are in v̂ as gravity is)
//
// over what contact left free, with μ, λ frozen at Δt's start as in the semi-implicit step. (From v = 0, one step of
// Newton's method without projection and line search is the paper's step 6 with β = 1.) Per-particle Hessians
// projected to positive semi-definite make every direction one of descent, so that the line search always ends.

template <Weights kind, class Real>
Convergence solve_newton(const Particles<Real>& ps, Grid<Real>& grid,
                         const std::vector<SnowModel<Real>>& materials, const StiffnessLimits& limits,
                         const std::vector<FixedNode<Real>>& all_fixed, const Vec3d& fall, double dt,
                         const Solver& solver) {
    using N4 = NodeVector<Real>;
    constexpr int most_steps = 30, most_halvings = 12;
    const Elements<Real, kind> elements(ps, grid, materials, limits);
    if (elements.size() == 0) return {};
    System<Real, kind> system(elements, grid, all_fixed, dt * dt, false);
    Potential<Real, kind> phi(elements, ps);
    const Pages<Real>& m = system.masses();
    const std::vector<std::uint32_t>& nodes = elements.grid_nodes();

    NodeField<Real> v(nodes.size()), f, r(nodes.size()), trial, difference(nodes.size());
    const NodeField<Real> load = forces_at_rest(ps, grid);
    v.for_each([&](std::ptrdiff_t i) {
        const Node<Real>& node = grid.nodes[nodes[i]];
        v.at[i] = N4::of(node[4] + fall(0), node[5] + fall(1), node[6] + fall(2), 0) + N4(m[i] > 0 ? Real(dt) / m[i] : 0) * load.at[nodes[i]];
    });
    for (const FixedNode<Real>& c : system.fixed()) {
        const N4& f_i = load.at[nodes[c.node]];
        const Vec3<Real> pushed = Real(dt) / m[c.node] * c.free * Vec3<Real>(f_i[0], f_i[1], f_i[2]);
        for (int a = 0; a < 3; ++a) v.at[c.node].lanes[a] = grid.nodes[nodes[c.node]][a] + pushed(a);
    }
    const NodeField<Real> v_hat = v;

    // Π, and r ← D⁻¹ (−∂Π/∂v) in the free directions.
    const auto evaluate = [&](const NodeField<Real>& at) {
        double energy = phi.move(at, dt, f);
        r.for_each([&](std::ptrdiff_t i) {
            difference.at[i] = at.at[i] - v_hat.at[i];
            r.at[i] = N4(Real(dt)) * f.at[i] - N4(m[i]) * difference.at[i];
        });
        system.scale(r), system.project(r);
        return energy + weighted_dot(m, difference, difference) / 2;
    };
    double energy = evaluate(v), norm = std::sqrt(system.dot(r, r));

    // Velocities and deformations are known to their last digit, and no residual can be better than that.
    const double round_off = std::numeric_limits<Real>::epsilon();
    const double floor =
        4 * round_off * (std::sqrt(system.dot(v, v)) + grid.h / dt * std::sqrt(system.weight()));
    const double first = norm, goal = std::max(solver.tolerance * first, floor);
    Convergence all;
    all.history = {1};
    NodeField<Real> step(nodes.size()), b;
    for (int n = 0; norm > goal && n < most_steps; ++n) {
        step.scale(0);
        const double forcing = std::max(std::min(0.5, std::sqrt(norm / first)) * 0.5, 0.5 * goal / norm);
        b = r;
        system.unscale(b);
        all.iterations += system.solve(step, b, phi, solver.linear_solver, forcing, 0, solver.max_iterations).iterations;
        const double slope = system.dot(r, step), noise = 8 * round_off * std::abs(energy);
        double alpha = 1, energy_there = 0;
        for (int halving = 0;; ++halving, alpha /= 2) {
            trial = v;
            trial.axpy(alpha, step);
            energy_there = evaluate(trial);
            if (energy_there <= energy - 1e-4 * alpha * slope + noise) break;
            if (halving == most_halvings) break;
        }
        if (!(energy_there <= energy + noise)) break;  // round-off is all that is left
        std::swap(v, trial);
        energy = energy_there, norm = std::sqrt(system.dot(r, r));
        all.history.push_back(float(norm / first));
    }
    all.converged = norm <= goal, all.unknowns = nodes.size();
    v.for_each([&](std::ptrdiff_t i) {
        for (int a = 0; a < 3; ++a) grid.nodes[nodes[i]].lanes[a] = v.at[i][a];
    });
    return all;
}

}  // namespace firn
