#pragma once
#include "sim/elements.h"

namespace firn {

/// ∂²Φ/∂x² of the implicit particles at F_Eⁿ with μ, λ frozen, matrix-free: A_p of report (4) through
/// `KirchhoffDifferential`.                                                                       report, (3)
template <class Real, Weights kind> class Hessian {
public:
    Hessian(const Elements<Real, kind>& elements, const Particles<Real>& ps) : elements_(elements), particles_(elements.size()) {
        elements.for_each([&](std::size_t n, const Element<Real, kind>& e) { particles_[n] = {left_strain(strains_of(ps, e)), e.k}; });
    }
    /// f_i = (∂²Φ/∂x² u)_i = Σ_p V_p⁰ A_p F_Eᵀ ∇w_ip
    void operator()(const NodeField<Real>& u, NodeField<Real>& f) const {
        elements_.map_gradients(u, f, [&](std::size_t n, const auto&, const auto& gradient) {
            return particles_[n](gradient); });
    }

private:
    const Elements<Real, kind>& elements_;
    Pages<KirchhoffDifferential<Pack<Real, lanes>>> particles_;
};

/// The same for F_E = I, Hooke's law:  A_p F_Eᵀ = 2μ sym G + λ tr G I. It is positive semi-definite, needs nothing of a
/// particle but its stiffness, and a rotation makes no force in it, so that a solve neither slows a spin nor starts one.
template <class Real, Weights kind> class LinearElasticHessian {
public:
    explicit LinearElasticHessian(const Elements<Real, kind>& elements) : elements_(elements) {}
    void operator()(const NodeField<Real>& u, NodeField<Real>& f) const {
        elements_.map_gradients(u, f, [](std::size_t, const auto& e, const auto& G) { return hooke(e, G); });
    }

private:
    using P = Pack<Real, lanes>;
    static Mat3<P> hooke(const Element<Real, kind>& e, const Mat3<P>& G) {
        Mat3<P> A = e.k.mu * (G + G.transpose());
        const P pressure = e.k.lambda * G.trace();
        for (int i = 0; i < 3; ++i) A(i, i) += pressure;
        return A;
    }
    const Elements<Real, kind>& elements_;
};

}  // namespace firn
