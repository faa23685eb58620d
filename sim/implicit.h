#pragma once
#include "sim/conjugate_residual.h"
#include "sim/node_field.h"
#include "sim/particles.h"
#include "sim/settings.h"
#include "sim/snow.h"
#include "sim/stiffness.h"

namespace firn {

/// The bodies at the time t [s], and how nodes meet them.
struct Bodies {
    const std::vector<Collider>& colliders;
    double t;
    NodeContact law;
    double flip_blend;              ///< α [1]
};

/// Step 6, for vⁿ⁺¹; what contact fixed keeps its v*, and `fixed` gets the impulses that hold it. The nodes hold (v*, m | vⁿ, 0), afterwards (vⁿ⁺¹, m | vⁿ, 0):
///
///   (M + β Δt² H) vⁿ⁺¹ = M v*,      H = Σ_p w_p ∂²Φ_p/∂x²
///
/// With w = 1 it is the paper's. The weight w_p leaves to the explicit force what it can bear (`implicit_weight`): the
/// implicit one damps motion that grids and steps resolve, and so would eat an impact's energy. Of an oscillation ω it
/// takes the share β w (ω Δt)² a step, and it is stable for every Δt from β = ½ on. Contact of v* is judged again by
/// what it gives over the whole step (`Rejudgement`).
template <Weights kind, class Real>
Convergence solve_implicit(const Particles<Real>&, Grid<Real>&, const std::vector<SnowModel<Real>>& materials,
                           const StiffnessLimits&, std::vector<FixedNode<Real>>& fixed, const Bodies&, double dt, const Solver&);

/// In place of steps 5 and 6: vⁿ⁺¹ minimises ½ ‖v − v̂‖²_M + Φ(x + Δt v) with v̂ = v + Δt g, in contact with the bodies;
/// `fall` is Δt g. The nodes and `fixed` hold what `collide_nodes` made of them; at nodes of implicit particles both are
/// made anew.
template <Weights kind, class Real>
Convergence solve_newton(const Particles<Real>&, Grid<Real>&, const std::vector<SnowModel<Real>>& materials,
                         const StiffnessLimits&, std::vector<FixedNode<Real>>& fixed, const Bodies&, const Vec3d& fall, double dt, const Solver&);

}  // namespace firn
