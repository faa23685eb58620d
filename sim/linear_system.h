#pragma once
#include "sim/conjugate_gradient.h"
#include "sim/elements.h"
#include "sim/minres.h"
#include "sim/pieces.h"
#include "sim/settings.h"

#include <algorithm>
#include <numeric>

namespace firn {

/// The nodes that contact fixed and that implicit particles reach, by their new numbers.
template <class Real, Weights kind>
std::vector<FixedNode<Real>> among(const Elements<Real, kind>& elements, const std::vector<FixedNode<Real>>& fixed) {
    std::vector<FixedNode<Real>> own;
    for (const FixedNode<Real>& f : fixed)
        if (const std::uint32_t i = elements.number_of(f.node); i != no_slot) own.push_back({.node = i, .free = f.free});
    return own;
}

/// The linear system of an implicit step,  (M + β Δt² H) u = b  in the directions that contact left free, scaled by
/// D = diag(M) + β Δt² diag(H):  E u = D⁻¹ (M + β Δt² H) u  is symmetric in the dot product a·D b.
template <class Real, Weights kind> class System {
public:
    /// `factor` is β Δt²; `rotations`: H knows no force of a rotation.
    System(const Elements<Real, kind>& elements, const Grid<Real>& grid, const std::vector<FixedNode<Real>>& fixed, double factor,
           bool rotations)
        : factor_(factor), m_(masses(elements, grid)), D_(elements.diagonal()), pieces_(elements, grid, m_, rotations) {
        hold(among(elements, fixed));
        for (std::size_t i = 0; i < m_.size(); ++i) D_[i] = m_[i] + Real(factor) * D_[i];
        inverse_D_.resize(m_.size());
        for (std::size_t i = 0; i < m_.size(); ++i) inverse_D_[i] = m_[i] > 0 ? 1 / D_[i] : 0;
    }
    /// From now on contact fixes these nodes, by their new numbers; H holds what is `attached`, even as a whole.
    void hold(std::vector<FixedNode<Real>> fixed, const std::vector<std::size_t>& attached = {}) {
        fixed_ = std::move(fixed);
        pieces_.hold(fixed_, attached);
    }
    const Pages<Real>& masses() const { return m_; }                           ///< [kg]
    const Pages<Real>& diagonal() const { return D_; }                         ///< [kg]
    const std::vector<FixedNode<Real>>& fixed() const { return fixed_; }
    double dot(const NodeField<Real>& a, const NodeField<Real>& b) const { return weighted_dot(D_, a, b); }
    double weight() const { return std::accumulate(D_.begin(), D_.end(), 0.0); }    ///< Σ D_i [kg]

    /// b ← D⁻¹ b; D⁻¹ b → b
    void scale(NodeField<Real>& b) const { b.for_each([&](std::ptrdiff_t i) { b.at[i] *= NodeVector<Real>(inverse_D_[i]); }); }
    void unscale(NodeField<Real>& b) const { b.for_each([&](std::ptrdiff_t i) { b.at[i] *= NodeVector<Real>(D_[i]); }); }
    /// ‖D⁻¹ b‖ in the free directions.
    double norm(NodeField<Real> b) const {
        scale(b), project(b);
        return std::sqrt(dot(b, b));
    }
    /// Free directions only.
    void project(NodeField<Real>& u) const { firn::project(fixed_, u); }

    /// Moves each piece that nothing holds so that the residual r, which is not scaled, leaves it no momentum to gain.
    void balance(NodeField<Real>& u, NodeField<Real>& r) { pieces_.balance(u, r); }

    /// u from 0 for the right side b; b becomes the residual, which holds u where contact fixed something. `floor`: of the
    /// residual's norm, scaled.
    template <class H>
    Convergence solve(NodeField<Real>& u, NodeField<Real>& b, const H& hessian, LinearSolver method, double tolerance, double floor,
                      int max_iterations) {
        using N4 = NodeVector<Real>;
        const auto E = [&](const NodeField<Real>& a, NodeField<Real>& Ea) {
            hessian(a, Ea);
            Ea.for_each([&](std::ptrdiff_t i) { Ea.at[i] = N4(inverse_D_[i]) * (N4(m_[i]) * a.at[i] + N4(Real(factor_)) * Ea.at[i]); });
        };
        const auto free_E = [&](const NodeField<Real>& a, NodeField<Real>& Ea) { E(a, Ea), project(Ea); };
        const auto product = [&](const NodeField<Real>& a, const NodeField<Real>& c) { return dot(a, c); };
        const double norm_b = norm(b);
        pieces_.balance(u, b);
        scale(b);
        Convergence c;
        if (method == LinearSolver::conjugate_gradient) {
            c = conjugate_gradient(u, b, norm_b, E, [&](NodeField<Real>& a) { project(a); }, product, {tolerance, floor, max_iterations});
        } else {
            NodeField<Real> r = b, du(u.at.size());
            project(r);
            const double norm_r = std::sqrt(dot(r, r));
            const Stopping stop{norm_r > 0 ? tolerance * norm_b / norm_r : 1, floor, max_iterations};
            c = method == LinearSolver::minres ? minres(du, r, free_E, product, stop) : conjugate_residual(du, r, free_E, product, stop);
            E(du, r);
            u.axpy(1, du), b.axpy(-1, r);
        }
        unscale(b);
        pieces_.balance(u, b);
        return c;
    }

private:
    static Pages<Real> masses(const Elements<Real, kind>& elements, const Grid<Real>& grid) {
        Pages<Real> m(elements.nodes());
        for (std::size_t i = 0; i < m.size(); ++i) m[i] = grid.nodes[elements.grid_nodes()[i]][3];
        return m;
    }

    double factor_;
    std::vector<FixedNode<Real>> fixed_;
    Pages<Real> m_, D_, inverse_D_;         ///< inverse: 0 where weights that vanish leave a node without mass.
    Pieces<Real, kind> pieces_;
};

}  // namespace firn
