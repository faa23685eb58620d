#pragma once
#include "sim/conjugate_residual.h"
#include "sim/node_field.h"
#include "sim/particles.h"
#include "sim/settings.h"
#include "sim/snow.h"
#include "sim/stiffness.h"

namespace firn {

/// Step 6, for vⁿ⁺¹; what contact fixed keeps its v*, and `fixed` gets the impulses that hold it. The nodes hold (v*, m | vⁿ, 0), afterwards (vⁿ⁺¹, m | vⁿ, 0):
///
///   M (vⁿ⁺¹ − v*) + Δt² H (β (vⁿ⁺¹ − vⁿ) + (γ − ½) vⁿ) = 0,      H = Σ_p w_p ∂²Φ_p/∂x²
///
/// With γ = β + ½ and w = 1 it is the paper's (M + β Δt² ∂²Φ/∂x²) vⁿ⁺¹ = M v*. It is Newmark's method with v between the
/// steps: (M + β Δt² H) a = f without damping for γ = ½, and stable for every Δt where 2β ≥ γ ≥ ½. The weight w_p leaves
/// to the explicit force what it can bear (`implicit_weight`): where w = 1 and γ > ½ too, an impact's energy is eaten.
template <Weights kind, class Real>
Convergence solve_implicit(const Particles<Real>&, Grid<Real>&, const std::vector<SnowModel<Real>>& materials,
                           const StiffnessLimits&, std::vector<FixedNode<Real>>& fixed, double dt, const Solver&);

/// In place of step 6: vⁿ⁺¹ minimises ½ ‖v − v̂‖²_M + Φ(x + Δt v) with v̂ = v + Δt g, after contact where it fixed
/// something; `fall` is Δt g.
template <Weights kind, class Real>
Convergence solve_newton(const Particles<Real>&, Grid<Real>&, const std::vector<SnowModel<Real>>& materials,
                         const StiffnessLimits&, const std::vector<FixedNode<Real>>& fixed, const Vec3d& fall, double dt, const Solver&);

}  // namespace firn
