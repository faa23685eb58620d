#pragma once
#include "sim/shape.h"

#include <optional>

namespace firn {

enum class Integrator { explicit_euler, semi_implicit, newton };
enum class LinearSolver { conjugate_gradient, conjugate_residual, minres };
enum class Transfer { flip, apic };
enum class Weights { cubic, quadratic };
enum class Precision { single, twofold };
enum class InitialVolume { grid, sampled };
enum class NodeContact { inelastic, elastic };

/// Whose values stand for what a scene does not give.
enum class Defaults { firn, paper };
/// How implicit a particle is in the semi-implicit step: as far as it is too stiff for an explicit one, or wholly.
enum class Stiff { weighted, all };

/// The numbers that trade speed for accuracy.
struct Solver {
    Defaults defaults = Defaults::firn;
    Integrator integrator = Integrator::semi_implicit;
    double beta = 0.6;                            ///< β [1] of the semi-implicit step: ½ trapezoidal, 1 backward Euler.
    Stiff stiff = Stiff::weighted;
    std::optional<double> stiff_limit;            ///< x_s = c Δt/h [1] up to which a particle is explicit; none: `stable_courant`.
    double strain_limit = 0.02;                   ///< greatest ‖Δt ∇v‖ [1] of a chosen Δt, but for a thousandth of the mass.
    std::optional<double> dt;                     ///< Δt [s]; none: chosen at every step.
    double max_dt = 2e-3;                         ///< upper bound of a chosen Δt [s].
    Transfer transfer = Transfer::flip;
    double flip_damping = 50;                     ///< [1/s]: α = exp(−Δt flip_damping) is the share of FLIP, the rest is PIC.
    std::optional<double> flip_blend;             ///< α [1] of every step, however short, in place of flip_damping: the paper's.
    Weights weights = Weights::quadratic;
    Precision precision = Precision::single;
    InitialVolume initial_volume = InitialVolume::sampled;  ///< V⁰ = m_p/ρ₀; grid: m_p/ρ_p of the paper's
                                                            ///< step 2, too large and so too stiff where snow ends.
    NodeContact node_contact = NodeContact::elastic;  ///< FLIP's step 5. elastic: the body bears forces, and strain stops snow;
                                                      ///< inelastic: the paper's, which brakes snow anew at every step.
    LinearSolver linear_solver = LinearSolver::conjugate_gradient;
    double tolerance = 1e-2;                      ///< residual of the solve, relative to the first one [1].
    int max_iterations = 100;                     ///< of a linear solve.
    double rest_speed = 0;                        ///< snow that is slower for rest_time sleeps [m/s]; 0: never.
    double rest_time = 0.1;                       ///< [s]; never less than 2 rest_speed/|g| in use.

    /// The paper's step where it has a value: what `defaults: paper` begins with.
    static Solver paper() {
        Solver s;
        s.defaults = Defaults::paper, s.beta = 1, s.stiff = Stiff::all, s.strain_limit = 0.2, s.max_dt = 1e-3;
        s.flip_blend = 0.95, s.weights = Weights::cubic, s.initial_volume = InitialVolume::grid, s.node_contact = NodeContact::inelastic;
        s.linear_solver = LinearSolver::conjugate_residual, s.tolerance = 1e-4, s.max_iterations = 30;
        return s;
    }
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
