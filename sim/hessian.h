#pragma once
#include "sim/elements.h"

namespace firn {

/// ∂²Φ/∂x² of all particles at F_Eⁿ with μ, λ frozen, matrix-free: A_p of report (4) through `KirchhoffDifferential`.
///                                                                                               report, (3)
template <class Real, Weights kind> class Hessian {
public:
    explicit Hessian(const Elements<Real, kind>& elements) : elements_(elements), particles_(elements.size()) {
        elements.for_each([&](std::size_t n, const Element<Real, kind>& e) { particles_[n] = {left_strain(e.Fe), e.k}; });
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

}  // namespace firn
