#pragma once
#include "sim/settings.h"
#include "sim/snow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace firn {

/// x_s: the largest c Δt/h [1] of an explicit step that is stable however the particles lie, c² = (λ + 2μ) V⁰/m.
/// A node's stiffness is at most s κ of a particle's (λ + 2μ) V⁰/h², where s is the largest Σ_i m_p ‖h ∇w_ip‖²/m_i
/// and κ = (3λ + 2μ)/(λ + 2μ) = (1+ν)/(1−ν) where volume changes, 2μ/(λ + 2μ) = (1−2ν)/(1−ν) where shape does; FLIP, which
/// forgets what the grid does not see, is stable for s κ x² ≤ 2. Measured at ν = 0.2 with 0.1 to 27 particles a cell:
/// 0.47 fails nowhere for quadratic weights, 0.66 for cubic ones; a little less is taken.
inline double stable_courant(Weights weights, double nu) {
    const double kappa = std::max(1 + nu, 1 - 2 * nu) / (1 - nu);
    return (weights == Weights::quadratic ? 0.45 : 0.6) * std::sqrt(1.5 / kappa);
}

/// The same, as the scene has it.
inline double stiff_limit(const Solver& solver, const Snow& snow) {
    return solver.stiff_limit.value_or(stable_courant(solver.weights, snow.nu));
}

/// From where on a particle is implicit.
struct StiffnessLimits {
    double scale2 = 0;              ///< (Δt/h)² [s²/m²]
    std::vector<double> limit2;     ///< x_s² of each material [1]; 0: all of it is wholly implicit.
    StiffnessLimits(const Solver& solver, const std::vector<Snow>& materials, double h, double dt) : scale2(dt * dt / (h * h)) {
        const bool all = solver.stiff == Stiff::all || solver.integrator == Integrator::newton;
        for (const Snow& snow : materials) limit2.push_back(all ? 0 : std::pow(stiff_limit(solver, snow), 2));
    }
};

/// How implicit a particle with x = c Δt/h is: its stiffness counts in the solve with the weight
///
///   w = max(0, 1 − (x_s/x)²)
///
/// so that what is left to the explicit force, (1 − w) x² ≤ x_s², is stable, and no particle is kicked when it hardens.
template <class T> T implicit_weight(T x2, T limit2) { return select(x2 > limit2, T(T(1) - limit2 / x2), T(0)); }

}  // namespace firn
