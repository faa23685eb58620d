#pragma once
#include <cmath>

namespace firn {

/// How a linear solve ended.
struct Convergence {
    int iterations = 0;
    double residual = 0;    ///< ‖b − E x‖ / ‖b‖ [1].
    bool converged = true;
};

/// Conjugate residuals for E x = b from x = 0, where E is symmetric under `dot`: dot(a, E b) = dot(b, E a).
/// (The paper's matrix I + β Δt² M⁻¹ ∂²Φ/∂x² is so for dot(a, b) = Σ m_i a_i·b_i, and for no other.) E may be
/// indefinite: the residual's norm never grows. Stops at ‖r‖ ≤ max(tolerance ‖b‖, floor).
///
/// Vector: x.axpy(a, y) adds a y to x; x.xpay(a, y) makes x into y + a x.
template <class Vector, class Apply, class Dot>
Convergence conjugate_residual(Vector& x, const Vector& b, Apply&& E, Dot&& dot, double tolerance, double floor,
                               int max_iterations) {
    const double norm_b = std::sqrt(dot(b, b));
    const double goal = std::fmax(tolerance * norm_b, floor);
    Convergence c;
    if (!(norm_b > floor)) return c;
    Vector r = b;                               // r ← b − E x
    Vector s = E(r);                            // s ← E r
    Vector p = r, q = s;                        // q ← E p
    double gamma = dot(r, s), norm = norm_b;    // γ ← r·s
    while (norm > goal && c.iterations < max_iterations) {
        const double qq = dot(q, q);
        if (!(qq > 0) || gamma == 0) break;     // no progress along p; only an indefinite E can do this
        const double alpha = gamma / qq;
        x.axpy(alpha, p);                       // x ← x + α p
        r.axpy(-alpha, q);                      // r ← r − α q
        s = E(r);
        const double gamma_new = dot(r, s), beta = gamma_new / gamma;
        gamma = gamma_new;
        p.xpay(beta, r);                        // p ← r + β p
        q.xpay(beta, s);                        // q ← s + β q
        norm = std::sqrt(dot(r, r));
        ++c.iterations;
    }
    c.residual = norm / norm_b;
    c.converged = norm <= goal;
    return c;
}

}  // namespace firn
