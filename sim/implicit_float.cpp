#include "sim/implicit.inl.h"
#include "sim/newton.inl.h"

namespace firn {

template Convergence solve_implicit<Weights::cubic>(const Particles<float>&, Grid<float>&, const std::vector<SnowModel<float>>&,
    const StiffnessLimits&, std::vector<FixedNode<float>>&, const Bodies&, double, const Solver&);
template Convergence solve_newton<Weights::cubic>(const Particles<float>&, Grid<float>&, const std::vector<SnowModel<float>>&,
    const StiffnessLimits&, std::vector<FixedNode<float>>&, const Bodies&, const Vec3d&, double, const Solver&);
template Convergence solve_implicit<Weights::quadratic>(const Particles<float>&, Grid<float>&, const std::vector<SnowModel<float>>&,
    const StiffnessLimits&, std::vector<FixedNode<float>>&, const Bodies&, double, const Solver&);
template Convergence solve_newton<Weights::quadratic>(const Particles<float>&, Grid<float>&, const std::vector<SnowModel<float>>&,
    const StiffnessLimits&, std::vector<FixedNode<float>>&, const Bodies&, const Vec3d&, double, const Solver&);

}  // namespace firn
