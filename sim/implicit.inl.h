#pragma once
#include "sim/hessian.h"
#include "sim/implicit.h"
#include "sim/linear_system.h"

#include <limits>

namespace firn {

template <Weights kind, class Real>
Convergence solve_implicit(const Particles<Real>& ps, Grid<Real>& grid,
                           const std::vector<SnowModel<Real>>& materials,
                           const std::vector<FixedNode<Real>>& fixed, double dt, const Solver& solver) {
    const Elements<Real, kind> elements(ps, grid, materials);
    const Hessian<Real, kind> hessian(elements);
    const double factor = solver.beta * dt * dt;
    const System<Real, kind> system(elements, grid, fixed, factor);

    const NodeField<Real> v_star = velocities(grid);
    NodeField<Real> b, dv(grid.size());
    hessian(v_star, b);
    b.scale(-factor);  // b = −β Δt² ∂²Φ/∂x² v*
    system.scale(b);
    const double floor = 4 * std::numeric_limits<Real>::epsilon() * std::sqrt(system.dot(v_star, v_star));
    const Convergence c =
        system.solve(dv, b, hessian, solver.linear_solver, {solver.tolerance, floor, solver.max_iterations});
    system.conserve_momentum(dv);
    dv.for_each([&](std::ptrdiff_t i) {
        for (int a = 0; a < 3; ++a) grid.nodes[i].lanes[a] += dv.at[i][a];
    });
    return c;
}

}  // namespace firn
