#pragma once
#include "sim/hessian.h"
#include "sim/implicit.h"
#include "sim/linear_system.h"

#include <limits>

namespace firn {

// With x₀ = vⁿ, but v* in what contact fixed, and u = vⁿ⁺¹ − x₀ the equation of solve_implicit reads
//
//   (M + β Δt² H) u = M (v* − x₀) − β Δt² H x₀.
//
// v* itself, the explicit step's end, would be a start that is far off wherever that step is unstable.

template <Weights kind, class Real>
Convergence solve_implicit(const Particles<Real>& ps, Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials,
                           const StiffnessLimits& limits, std::vector<FixedNode<Real>>& fixed, double dt, const Solver& solver) {
    using N4 = NodeVector<Real>;
    const Elements<Real, kind> elements(ps, grid, materials, limits);
    if (elements.size() == 0) return {};
    const bool hooke = solver.linear_solver == LinearSolver::conjugate_gradient;
    System<Real, kind> system(elements, grid, fixed, solver.beta * dt * dt, hooke);
    const Pages<Real>& m = system.masses();
    const std::vector<std::uint32_t>& nodes = elements.grid_nodes();

    NodeField<Real> v_star(nodes.size()), x0(nodes.size()), b(nodes.size()), u(nodes.size());
    x0.for_each([&](std::ptrdiff_t i) {
        const Node<Real>& n = grid.nodes[nodes[i]];
        v_star.at[i] = N4::of(n[0], n[1], n[2], 0), x0.at[i] = N4::of(n[4], n[5], n[6], 0);
    });
    for (const FixedNode<Real>& f : system.fixed()) {       // vⁿ + (I − P)(v* − vⁿ)
        const N4 change = v_star.at[f.node] - x0.at[f.node];
        const Vec3<Real> d(change[0], change[1], change[2]), held = d - f.free * d;
        x0.at[f.node] += N4::of(held(0), held(1), held(2), 0);
    }
    const double factor = solver.beta * dt * dt;
    const auto go = [&](const auto& hessian) {
        hessian(x0, b);
        b.for_each([&](std::ptrdiff_t i) { b.at[i] = N4(m[i]) * (v_star.at[i] - x0.at[i]) - N4(Real(factor)) * b.at[i]; });
        const double floor = 4 * std::numeric_limits<Real>::epsilon() * std::sqrt(system.dot(v_star, v_star));
        return system.solve(u, b, hessian, solver.linear_solver, solver.tolerance, floor, solver.max_iterations);
    };
    Convergence c = hooke ? go(LinearElasticHessian<Real, kind>(elements)) : go(Hessian<Real, kind>(elements, ps));
    u.for_each([&](std::ptrdiff_t i) {
        for (int a = 0; a < 3; ++a) grid.nodes[nodes[i]].lanes[a] = x0.at[i][a] + u.at[i][a];
    });
    for (FixedNode<Real>& f : fixed) {
        const std::uint32_t i = elements.number_of(f.node);
        if (i == no_slot) continue;
        const Vec3<Real> r(b.at[i][0], b.at[i][1], b.at[i][2]);
        f.impulse -= r - f.free * r;
    }
    c.unknowns = nodes.size();
    return c;
}

}  // namespace firn
