#pragma once
#include "sim/elements.h"
#include "sim/projected_hessian.h"

namespace firn {

/// Φ(x + Δt v), its forces, and its projected Hessian there.
template <class Real, Weights kind> class Potential {
public:
    using P = Pack<Real, lanes>;
    Potential(const Elements<Real, kind>& elements, const Particles<Real>& ps)
        : elements_(elements), Fe_(elements.size()), energy_(elements.size()), particles_(elements.size()) {
        elements.for_each([&](std::size_t n, const Element<Real, kind>& e) { Fe_[n] = strains_of(ps, e); });
    }

    /// Moves to x + Δt v: f ← −∂Φ/∂x. Returns Φ.
    double move(const NodeField<Real>& v, double dt, NodeField<Real>& f) {
        elements_.map_gradients(v, f, [&](std::size_t n, const Element<Real, kind>& e, const Mat3<P>& gradient) {
            const Mat3<P> F = Fe_[n] + P(Real(dt)) * gradient * Fe_[n];
            const Decomposition<P> d = decompose(F);
            particles_[n] = {d, Fe_[n], e.k};
            const P density = energy_density(d.s, e.k);
            double sum = 0;
            for (int l = 0; l < lanes; ++l) sum += density[l];    // 0 in lanes without a particle: V⁰ μ = 0
            energy_[n] = sum;
            return Mat3<P>(-(d.U * principal_stress(d.s, e.k).asDiagonal() * d.V.transpose()) * Fe_[n].transpose());
        });
        double sum = 0;
        for (const double s : energy_) sum += s;
        return sum;
    }
    /// The projected Hessian where it was moved to last.
    void operator()(const NodeField<Real>& u, NodeField<Real>& f) const {
        elements_.map_gradients(u, f, [&](std::size_t n, const auto&, const auto& gradient) { return particles_[n](gradient); });
    }

private:
    const Elements<Real, kind>& elements_;
    Pages<Mat3<P>> Fe_;                 ///< F_Eⁿ
    std::vector<double> energy_;
    Pages<ProjectedDifferential<P>> particles_;
};

}  // namespace firn
