#pragma once
#include "sim/shape.h"

#include <optional>

namespace firn {

enum class Integrator { explicit_euler, semi_implicit, newton };
enum class LinearSolver { conjugate_residual, minres };
enum class Transfer { flip, apic };
enum class Weights { cubic, quadratic };
enum class Precision { single, twofold };
enum class InitialVolume { grid, sampled };

/// The numbers that trade speed for accuracy.
struct Solver {
    Integrator integrator = Integrator::semi_implicit;
    double beta = 1;                              ///< β [1] of the semi-implicit step: ½ trapezoidal, 1 backward Euler.
    std::optional<double> dt;                     ///< Δt [s]; none: chosen at every step.
    double max_dt = 1e-3;                         ///< upper bound of a chosen Δt [s].
    Transfer transfer = Transfer::flip;
    double flip_blend = 0.95;                     ///< α [1]: share of FLIP; 0 is PIC, which damps most.
    Weights weights = Weights::cubic;
    Precision precision = Precision::single;
    InitialVolume initial_volume = InitialVolume::grid;  ///< V⁰ = m_p/ρ_p of step 2, or m_p/ρ₀.
    LinearSolver linear_solver = LinearSolver::conjugate_residual;
    double tolerance = 1e-4;                      ///< residual of the solve, relative to the first one [1].
    int max_iterations = 30;                      ///< of a linear solve.
    double rest_speed = 0;                        ///< snow that is slower for rest_time sleeps [m/s]; 0: never.
    double rest_time = 0.1;                       ///< [s]; never less than 2 rest_speed/|g| in use.
};

enum class ContactLaw { slide, sticky };

/// A rigid body that snow cannot enter.
struct Collider {
    Shape shape;                        ///< Plane, sphere, box, cylinder or capsule, where it is at t = 0.
    ContactLaw contact = ContactLaw::slide;
    double friction = 0.4;              ///< Coulomb's μ [1]; a sticky body does not use it.
    Vec3d velocity{0, 0, 0};            ///< v_co [m/s], constant: the body moves along.
};

}  // namespace firn
