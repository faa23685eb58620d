#pragma once
#include <cmath>
#include <vector>

namespace firn {

/// How a solve ended.
struct Convergence {
    int iterations = 0;
    bool converged = true;
    std::size_t unknowns = 0;       ///< nodes that were solved for.
    std::vector<float> history{};   ///< ‖b − E x‖ / ‖b‖ at the start and after every iteration [1].
    double residual() const { return history.empty() ? 0 : history.back(); }
};

/// When to stop: at ‖r‖ ≤ max(tolerance ‖b‖, floor), or when there have been so many iterations.
struct Stopping {
    double tolerance, floor;
    int max_iterations;
};

/// Conjugate residuals, the paper's solver, for E x = b from x = 0, where E is symmetric under `dot`:
/// dot(a, E b) = dot(b, E a). (The paper's matrix I + β Δt² M⁻¹ ∂²Φ/∂x² is so for dot(a, b) = Σ m_i a_i·b_i, and
/// not for the plain one.) The residual's norm never grows. Where E is indefinite, r·E r can vanish before the
/// end: the solve then stops and says that it did not converge (see minres.h).
///
/// Vector: x.axpy(a, y) adds a y to x; x.xpay(a, y) makes x into y + a x; x.scale(a) into a x. E(x, y) makes y into E x.
template <class Vector, class Apply, class Dot>
Convergence conjugate_residual(Vector& x, const Vector& b, Apply&& E, Dot&& dot, const Stopping& stop) {
    const double norm_b = std::sqrt(dot(b, b)), goal = std::fmax(stop.tolerance * norm_b, stop.floor);
    Convergence c;
    if (!(norm_b > stop.floor)) return c;
    Vector r = b;                               // r ← b − E x
    Vector s = r;
    E(r, s);                                    // s ← E r
    Vector p = r, q = s;                        // q ← E p
    double gamma = dot(r, s), norm = norm_b;    // γ ← r·s
    c.history = {1};
    while (norm > goal && c.iterations < stop.max_iterations) {
        const double qq = dot(q, q);
        if (!(qq > 0) || gamma == 0) break;     // no progress along p; only an indefinite E can do this
        const double alpha = gamma / qq;
        x.axpy(alpha, p);                       // x ← x + α p
        r.axpy(-alpha, q);                      // r ← r − α q
        E(r, s);
        const double gamma_new = dot(r, s), beta = gamma_new / gamma;
        gamma = gamma_new;
        p.xpay(beta, r);                        // p ← r + β p
        q.xpay(beta, s);                        // q ← s + β q
        norm = std::sqrt(dot(r, r));
        ++c.iterations;
        c.history.push_back(float(norm / norm_b));
    }
    c.converged = norm <= goal;
    return c;
}

}  // namespace firn
