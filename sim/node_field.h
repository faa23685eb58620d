#pragma once
#include "sim/grid.h"

namespace firn {

/// A vector at every node, for the linear solve: x y z 0.
template <class Real> using NodeVector = Pack<Real, 4>;

template <class Real> struct NodeField {
    Pages<NodeVector<Real>> at;

    explicit NodeField(std::size_t nodes = 0) : at(nodes, NodeVector<Real>(0)) {}

    /// Calls f(node) for all nodes, several at once.
    template <class F> void for_each(F&& f) const {
        const auto n = static_cast<std::ptrdiff_t>(at.size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t i = 0; i < n; ++i) f(i);
    }
    void axpy(double a, const NodeField& y) {
        for_each([&, a = NodeVector<Real>(Real(a))](std::ptrdiff_t i) { at[i] += a * y.at[i]; });
    }
    void scale(double a) {
        for_each([&, a = NodeVector<Real>(Real(a))](std::ptrdiff_t i) { at[i] *= a; });
    }
    void xpay(double a, const NodeField& y) {
        for_each([&, a = NodeVector<Real>(Real(a))](std::ptrdiff_t i) { at[i] = y.at[i] + a * at[i]; });
    }
};

/// Σ_i f(i) of four doubles each: of 256 nodes at a time, added up in a fixed order.
template <class F> Pack<double, 4> sum_over(std::ptrdiff_t n, F&& f) {
    constexpr std::ptrdiff_t chunk = 256;
    const std::ptrdiff_t chunks = (n + chunk - 1) / chunk;
    std::vector<Pack<double, 4>> partial(chunks);
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t c = 0; c < chunks; ++c) {
        Pack<double, 4> sum(0);
        for (std::ptrdiff_t i = c * chunk; i < std::min((c + 1) * chunk, n); ++i) sum += f(i);
        partial[c] = sum;
    }
    Pack<double, 4> sum(0);
    for (const Pack<double, 4>& s : partial) sum += s;
    return sum;
}

/// Σ_i D_i a_i·b_i for positive weights D.
template <class Real>
double weighted_dot(const Pages<Real>& D, const NodeField<Real>& a, const NodeField<Real>& b) {
    const auto sum = sum_over(static_cast<std::ptrdiff_t>(D.size()), [&](std::ptrdiff_t i) {
        const NodeVector<Real> ab = a.at[i] * b.at[i];
        return Pack<double, 4>(double(D[i])) * Pack<double, 4>::of(ab[0], ab[1], ab[2], 0);
    });
    return sum[0] + sum[1] + sum[2];
}

/// A node at which contact fixed something.
template <class Real> struct FixedNode {
    std::size_t node;
    Mat3<Real> free;                    ///< projector onto what it left free.
    Vec3<Real> v_n{0, 0, 0};            ///< vⁿ, as its particles make it [m/s].
    Vec3<Real> impulse{0, 0, 0};        ///< of contact on the snow, as far as v* and vⁿ⁺¹ have it [N s].
    Vec3d x{0, 0, 0};                   ///< where it is [m].
};

/// Leaves of u what contact left free.
template <class Real> void project(const std::vector<FixedNode<Real>>& fixed, NodeField<Real>& u) {
    for (const FixedNode<Real>& f : fixed) {
        NodeVector<Real>& at = u.at[f.node];
        const Vec3<Real> a = f.free * Vec3<Real>(at[0], at[1], at[2]);
        at = NodeVector<Real>::of(a(0), a(1), a(2), 0);
    }
}

}  // namespace firn
