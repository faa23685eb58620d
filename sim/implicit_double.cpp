#include "sim/implicit.inl.h"
#include "sim/newton.inl.h"

namespace firn {

template Convergence solve_implicit<Weights::cubic>(const Particles<double>&, Grid<double>&, const std::vector<SnowModel<double>>&,
    const StiffnessLimits&, std::vector<FixedNode<double>>&, const Bodies&, double, const Solver&);
template Convergence solve_newton<Weights::cubic>(const Particles<double>&, Grid<double>&, const std::vector<SnowModel<double>>&,
    const StiffnessLimits&, std::vector<FixedNode<double>>&, const Bodies&, const Vec3d&, double, const Solver&);
template Convergence solve_implicit<Weights::quadratic>(const Particles<double>&, Grid<double>&, const std::vector<SnowModel<double>>&,
    const StiffnessLimits&, std::vector<FixedNode<double>>&, const Bodies&, double, const Solver&);
template Convergence solve_newton<Weights::quadratic>(const Particles<double>&, Grid<double>&, const std::vector<SnowModel<double>>&,
    const StiffnessLimits&, std::vector<FixedNode<double>>&, const Bodies&, const Vec3d&, double, const Solver&);

}  // namespace firn
