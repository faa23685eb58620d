#pragma once
#include "sim/conjugate_residual.h"

namespace firn {

/// Conjugate gradients for E x = b from the x that is given, whose residual b − E x is r, where E is symmetric and positive
/// definite under `dot` on the vectors that `project` leaves as they are; x stays one of them. Afterwards r is the residual
/// of the new x, with the part that `project` would take, which is what holds x there. Vectors as in conjugate_residual.h.
template <class Vector, class Apply, class Project, class Dot>
Convergence conjugate_gradient(Vector& x, Vector& r, double norm_b, Apply&& E, Project&& project, Dot&& dot, const Stopping& stop) {
    Vector z = r;
    project(z);
    double rho = dot(z, z), norm = std::sqrt(rho);      // ρ ← r·r
    const double goal = std::fmax(stop.tolerance * norm_b, stop.floor);
    Convergence c;
    if (!(norm > goal)) return c;
    Vector p = z, q = z;
    c.history = {float(norm / norm_b)};
    while (norm > goal && c.iterations < stop.max_iterations) {
        E(p, q);                                        // q ← E p
        const double pq = dot(p, q);
        if (!(pq > 0)) break;                           // E is not positive definite, or a number is none any more
        x.axpy(rho / pq, p);                            // x ← x + α p
        r.axpy(-rho / pq, q);                           // r ← r − α q
        z = r;
        project(z);
        const double rho_new = dot(z, z);
        p.xpay(rho_new / rho, z);                       // p ← r + β p
        rho = rho_new, norm = std::sqrt(rho);
        ++c.iterations;
        c.history.push_back(float(norm / norm_b));
    }
    c.converged = norm <= goal;
    return c;
}

}  // namespace firn
