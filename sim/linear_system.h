#pragma once
#include "sim/elements.h"
#include "sim/minres.h"
#include "sim/settings.h"

#include <algorithm>
#include <numeric>

namespace firn {

/// The linear system of an implicit step,  (M + β Δt² H) u = b  in the directions that contact left free, scaled by
/// D = diag(M) + β Δt² diag(H):  E u = D⁻¹ (M + β Δt² H) u  is symmetric in the dot product a·D b.
template <class Real, Weights kind> class System {
public:
    /// `factor` is β Δt².
    System(const Elements<Real, kind>& elements, const Grid<Real>& grid, const std::vector<FixedNode<Real>>& fixed,
           double factor)
        : factor_(factor), fixed_(fixed), m_(grid.size()), D_(grid.size()) {
        const Pages<Real> stiffness = elements.diagonal();
        for (std::size_t i = 0; i < m_.size(); ++i) m_[i] = grid.nodes[i][3], D_[i] = m_[i] + Real(factor) * stiffness[i];
    }
    const Pages<Real>& masses() const { return m_; }                           ///< [kg]
    double dot(const NodeField<Real>& a, const NodeField<Real>& b) const { return weighted_dot(D_, a, b); }

    double weight() const { return std::accumulate(D_.begin(), D_.end(), 0.0); }    ///< Σ D_i [kg]

    /// b ← D⁻¹ b, free directions only.
    void scale(NodeField<Real>& b) const {
        using N4 = NodeVector<Real>;
        b.for_each([&](std::ptrdiff_t i) { b.at[i] *= N4(m_[i] > 0 ? 1 / D_[i] : Real(0)); });
        project(fixed_, b);
    }
    /// u from 0, for b that has been scaled.
    template <class H>
    Convergence solve(NodeField<Real>& u, const NodeField<Real>& b, const H& hessian, LinearSolver method, const Stopping& stop) const {
        using N4 = NodeVector<Real>;
        const auto E = [&](const NodeField<Real>& a, NodeField<Real>& Ea) {
            hessian(a, Ea);
            Ea.for_each([&](std::ptrdiff_t i) { Ea.at[i] = N4(m_[i]) * a.at[i] + N4(Real(factor_)) * Ea.at[i]; });
            scale(Ea);
        };
        const auto product = [&](const NodeField<Real>& a, const NodeField<Real>& c) { return dot(a, c); };
        return method == LinearSolver::minres ? minres(u, b, E, product, stop) : conjugate_residual(u, b, E, product, stop);
    }

    /// Internal forces make no momentum, but a solve that ends early would leave some, of the tolerance's size:
    /// takes it from the nodes' changes of velocity, in proportion to their size, along every axis along which
    /// contact fixed nothing.
    void conserve_momentum(NodeField<Real>& change) const {
        using D4 = Pack<double, 4>;
        D4 momentum(0);
        double weight = 0;
        for (std::size_t i = 0; i < m_.size(); ++i) {
            const NodeVector<Real>& dv = change.at[i];
            momentum += D4(double(m_[i])) * D4::of(dv[0], dv[1], dv[2], 0);
            weight += double(m_[i]) * std::sqrt(double((dv * dv)[0] + (dv * dv)[1] + (dv * dv)[2]));
        }
        NodeVector<Real> excess(0);
        for (int a = 0; a < 3 && weight > 0; ++a)
            if (std::all_of(fixed_.begin(), fixed_.end(), [a](const FixedNode<Real>& f) { return f.free(a, a) == 1; }))
                excess.lanes[a] = Real(momentum[a] / weight);
        change.for_each([&](std::ptrdiff_t i) {
            const NodeVector<Real> squared = change.at[i] * change.at[i];
            change.at[i] -= NodeVector<Real>(std::sqrt(squared[0] + squared[1] + squared[2])) * excess;
        });
    }

private:
    double factor_;
    const std::vector<FixedNode<Real>>& fixed_;
    Pages<Real> m_, D_;
};

/// v* of the nodes that hold (v*, m | …).
template <class Real> NodeField<Real> velocities(const Grid<Real>& grid) {
    NodeField<Real> v(grid.size());
    v.for_each([&](std::ptrdiff_t i) { v.at[i] = NodeVector<Real>::of(grid.nodes[i][0], grid.nodes[i][1], grid.nodes[i][2], 0); });
    return v;
}

}  // namespace firn
