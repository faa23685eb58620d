#pragma once
#include "sim/implicit.h"
#include "sim/linear_system.h"
#include "sim/potential.h"
#include "sim/reactions.h"
#include "sim/rest.h"

#include <limits>

namespace firn {

// The fully implicit step (Gast, Schroeder, Stomakhin, Jiang, Teran 2015): vⁿ⁺¹ minimises
//
//   Π(v) = ½ ‖v − v̂‖²_M + Φ(x + Δt v) + Σ ψ(v),      ∂Π/∂v = M (v − v̂) − Δt f(x + Δt v) − q,      v̂ = v + Δt g
//
// (the forces of snow at rest do not change, and are in v̂ as gravity is; ψ and q are friction's)
//
// over what contact left free, with μ, λ frozen at Δt's start as in the semi-implicit step. (From v = 0, one step of
// Newton's method without projection and line search is the paper's step 6 with β = 1.) Per-particle Hessians
// projected to positive semi-definite make every direction one of descent, so that the line search always ends.
//
// Contact is judged by what the bodies give over the whole step, r = M (v − v̂) − Δt f(x + Δt v) [kg m/s]. The laws of
// contact hold of r and v at a node if contact makes v of v − r/D, whatever D > 0. So minimising and contact of v − r/D
// take turns until contact changes nothing: it says what is fixed, and how much friction what slides can have. D is the
// system's diagonal, the impulse that it takes to move a node. The first turn begins with contact of v*.

/// Gives the nodes of implicit particles the v* and vⁿ that they had before `collide_nodes`, and takes them from `fixed`.
template <Weights kind, class Real>
void undo_contact(const Elements<Real, kind>& elements, Grid<Real>& grid, std::vector<FixedNode<Real>>& fixed) {
    const auto end = std::remove_if(fixed.begin(), fixed.end(), [&](const FixedNode<Real>& c) {
        if (elements.number_of(c.node) == no_slot) return false;
        Node<Real>& n = grid.nodes[c.node];
        for (int a = 0; a < 3; ++a) n.lanes[a] -= c.impulse(a) / n[3], n.lanes[4 + a] = c.v_n(a);
        return true;
    });
    fixed.erase(end, fixed.end());
}

template <Weights kind, class Real>
Convergence solve_newton(const Particles<Real>& ps, Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials,
                         const StiffnessLimits& limits, std::vector<FixedNode<Real>>& fixed, const Bodies& bodies, const Vec3d& fall,
                         double dt, const Solver& solver) {
    using N4 = NodeVector<Real>;
    constexpr int most_turns = 20, most_steps = 30, most_halvings = 12;
    const Elements<Real, kind> elements(ps, grid, materials, limits);
    if (elements.size() == 0) return {};
    undo_contact(elements, grid, fixed);
    Reactions<Real> contact(elements, grid, bodies);
    System<Real, kind> system(elements, grid, {}, dt * dt, false);
    Potential<Real, kind> phi(elements, ps);
    const Pages<Real>& m = system.masses();
    const std::vector<std::uint32_t>& nodes = elements.grid_nodes();

    NodeField<Real> v_hat(nodes.size()), f, residual(nodes.size()), r, next, difference(nodes.size());
    const NodeField<Real> load = forces_at_rest(ps, grid);
    v_hat.for_each([&](std::ptrdiff_t i) {
        const Node<Real>& node = grid.nodes[nodes[i]];
        v_hat.at[i] = N4::of(node[4] + fall(0), node[5] + fall(1), node[6] + fall(2), 0) + N4(m[i] > 0 ? Real(dt) / m[i] : 0) * load.at[nodes[i]];
    });
    NodeField<Real> v = v_hat;

    // Π, −∂Π/∂v, and r ← D⁻¹ of it in the free directions.
    const auto evaluate = [&](const NodeField<Real>& at) {
        double energy = phi.move(at, dt, f);
        residual.for_each([&](std::ptrdiff_t i) {
            difference.at[i] = at.at[i] - v_hat.at[i];
            residual.at[i] = N4(Real(dt)) * f.at[i] - N4(m[i]) * difference.at[i];
        });
        for (Friction<Real>& c : contact.frictions()) energy += c.move(at, residual);
        r = residual;
        system.scale(r), system.project(r);
        return energy + weighted_dot(m, difference, difference) / 2;
    };
    const auto hessian = [&](const NodeField<Real>& u, NodeField<Real>& Hu) {
        phi(u, Hu);
        for (const Friction<Real>& c : contact.frictions()) c.add_product(u, Real(1 / (dt * dt)), Hu);
    };
    contact.judge_start(v);
    system.hold(contact.fixed(), contact.rough());
    double energy = evaluate(v), norm = std::sqrt(system.dot(r, r));

    // Velocities and deformations are known to their last digit, and no residual can be better than that.
    const double round_off = std::numeric_limits<Real>::epsilon();
    const double floor =
        4 * round_off * (std::sqrt(system.dot(v, v)) + grid.h / dt * std::sqrt(system.weight()));
    const double first = norm, goal = std::max(solver.tolerance * first, floor);
    Convergence all;
    all.history = {1};
    NodeField<Real> step(nodes.size()), b;
    // Newton's method for what is fixed now. False: round-off is all that is left.
    const auto minimise = [&] {
        for (int n = 0; norm > goal && n < most_steps; ++n) {
            step.scale(0);
            const double forcing = std::max(std::min(0.5, std::sqrt(norm / first)) * 0.5, 0.5 * goal / norm);
            b = r;
            system.unscale(b);
            all.iterations += system.solve(step, b, hessian, solver.linear_solver, forcing, 0, solver.max_iterations).iterations;
            const double slope = system.dot(r, step), noise = 8 * round_off * std::abs(energy);
            double alpha = 1, energy_there = 0;
            for (int halving = 0;; ++halving, alpha /= 2) {
                next = v;
                next.axpy(alpha, step);
                energy_there = evaluate(next);
                if (energy_there <= energy - 1e-4 * alpha * slope + noise) break;
                if (halving == most_halvings) break;
            }
            if (!(energy_there <= energy + noise)) return false;
            std::swap(v, next);
            energy = energy_there, norm = std::sqrt(system.dot(r, r));
            all.history.push_back(float(norm / first));
        }
        return true;
    };
    for (int turn = 0; minimise() && !contact.empty() && turn < most_turns; ++turn) {
        contact.judge_reactions(system.diagonal(), v_hat, f, dt, v);
        system.hold(contact.fixed(), contact.rough());
        energy = evaluate(v), norm = std::sqrt(system.dot(r, r));
        if (norm <= goal) break;
    }
    all.converged = norm <= goal, all.unknowns = nodes.size();
    evaluate(v);
    system.hold(contact.fixed());               // what friction gave stays what it is
    system.balance(v, residual);
    v.for_each([&](std::ptrdiff_t i) {
        for (int a = 0; a < 3; ++a) grid.nodes[nodes[i]].lanes[a] = v.at[i][a];
    });
    contact.finish(v_hat, f, dt, v, grid, fixed);
    return all;
}

}  // namespace firn
