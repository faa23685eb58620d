#pragma once
#include "sim/conjugate_residual.h"

namespace firn {

/// MINRES (Paige and Saunders 1975) for E x = b from x = 0, E symmetric under `dot`, definite or not. The same
/// iterates as conjugate residuals in exact arithmetic, but without their division by r·E r: the Lanczos vectors
/// v span the same space, and the least-squares problem in it is solved by rotations. Vector, E: as there.
template <class Vector, class Apply, class Dot>
Convergence minres(Vector& x, const Vector& b, Apply&& E, Dot&& dot, const Stopping& stop) {
    const double norm_b = std::sqrt(dot(b, b)), goal = std::fmax(stop.tolerance * norm_b, stop.floor);
    Convergence c;
    if (!(norm_b > stop.floor)) return c;
    Vector v = b, v_old = b, w = b, w_old = b, next = b;
    v.scale(1 / norm_b);
    v_old.scale(0), w.scale(0), w_old.scale(0);
    double beta = 0, eta = norm_b, cosine = 1, cosine_old = 1, sine = 0, sine_old = 0;
    c.history = {1};
    while (std::fabs(eta) > goal && c.iterations < stop.max_iterations) {
        E(v, next);                                     // Lanczos: β_{k+1} v_{k+1} = E v − α v − β_k v_{k−1}
        const double alpha = dot(v, next);
        next.axpy(-alpha, v), next.axpy(-beta, v_old);
        const double beta_new = std::sqrt(dot(next, next));

        // The new column of the tridiagonal matrix, turned by the last two rotations and then by a new one.
        const double gamma = cosine * alpha - cosine_old * sine * beta, length = std::hypot(gamma, beta_new);
        const double above = sine * alpha + cosine_old * cosine * beta, above2 = sine_old * beta;
        if (!(length > 0)) break;                       // E is singular, and b has a part in its null space
        cosine_old = cosine, sine_old = sine;
        cosine = gamma / length, sine = beta_new / length;

        w_old.xpay(-above2, v), w_old.axpy(-above, w);  // w ← (v − γ₂ w − γ₃ w_old) / γ₁
        w_old.scale(1 / length);
        std::swap(w, w_old);
        x.axpy(cosine * eta, w);
        eta *= -sine;
        ++c.iterations;
        c.history.push_back(float(std::fabs(eta) / norm_b));
        if (!(beta_new > 0)) break;                     // the space is exhausted: x is exact
        std::swap(v_old, v);
        std::swap(v, next);
        v.scale(1 / beta_new);
        beta = beta_new;
    }
    c.converged = std::fabs(eta) <= goal;
    return c;
}

}  // namespace firn
