#pragma once
#include "sim/elements.h"

namespace firn {

/// V_p⁰ A_p F_Eᵀ of eight particles as a function of ∇u, A_p = ∂²Ψ/∂F_E∂F_E : (∇u F_E), with δR through the
/// report's 3×3 system.                                                                             report, (4)
template <class P> struct StressDifferential {
    Mat3<P> F, R, K;    ///< F_E, its rotation, (tr S · I − S)⁻¹
    Lame<P> k;          ///< V⁰ μ and V⁰ λ

    StressDifferential() = default;
    StressDifferential(const Mat3<P>& Fe, const Lame<P>& lame) : F(Fe), k(lame) {
        const Decomposition<P> d = decompose(Fe);
        R = d.rotation();
        K = rotation_system_inverse(Mat3<P>(d.V * d.s.asDiagonal() * d.V.transpose()));
    }
    Mat3<P> operator()(const Mat3<P>& gradient) const {
        const Mat3<P> dF = gradient * F;
        return stress_differential(F, rotation_differential(R, K, dF), k, dF) * F.transpose();
    }
};

/// ∂²Φ/∂x² of all particles at F_Eⁿ with μ, λ frozen, matrix-free.                                   report, (3)
template <class Real, Weights kind> class Hessian {
public:
    explicit Hessian(const Elements<Real, kind>& elements) : elements_(elements), particles_(elements.size()) {
        elements.for_each([&](std::size_t n, const Element<Real, kind>& e) { particles_[n] = {e.Fe, e.k}; });
    }
    /// f_i = (∂²Φ/∂x² u)_i = Σ_p V_p⁰ A_p F_Eᵀ ∇w_ip
    void operator()(const NodeField<Real>& u, NodeField<Real>& f) const {
        elements_.map_gradients(u, f, [&](std::size_t n, const auto&, const auto& gradient) {
            return particles_[n](gradient); });
    }

private:
    const Elements<Real, kind>& elements_;
    std::vector<StressDifferential<Pack<Real, lanes>>> particles_;
};

}  // namespace firn
