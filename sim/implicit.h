#pragma once
#include "sim/conjugate_residual.h"
#include "sim/node_field.h"
#include "sim/particles.h"
#include "sim/settings.h"
#include "sim/snow.h"

namespace firn {

/// Step 6:  (M + β Δt² ∂²Φ/∂x²) vⁿ⁺¹ = M v*, the paper's equation times M, solved for vⁿ⁺¹ − v*; what contact
/// fixed keeps its v*. The nodes hold v* and m, afterwards vⁿ⁺¹.
template <Weights kind, class Real>
Convergence solve_implicit(const Particles<Real>&, Grid<Real>&, const std::vector<SnowModel<Real>>& materials,
                           const std::vector<FixedNode<Real>>& fixed, double dt, const Solver&);

/// In place of step 6: vⁿ⁺¹ minimises ½ ‖v − v̂‖²_M + Φ(x + Δt v) with v̂ = v + Δt g, after contact where it fixed
/// something; `fall` is Δt g.
template <Weights kind, class Real>
Convergence solve_newton(const Particles<Real>&, Grid<Real>&, const std::vector<SnowModel<Real>>& materials,
                         const std::vector<FixedNode<Real>>& fixed, const Vec3d& fall, double dt, const Solver&);

}  // namespace firn
