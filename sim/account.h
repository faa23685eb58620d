#pragma once
#include "sim/collision.h"
#include "sim/grid.h"
#include "sim/ledger.h"
#include "sim/node_field.h"
#include "sim/rest.h"

namespace firn {

/// An impulse J on the snow at x, of the bodies there: those whose normals it goes along have their shares of it.
inline void share_out(const Vec3d& x, const Vec3d& J, const std::vector<Collider>& colliders, double t, std::vector<Exchange>& exchanges) {
    std::vector<std::pair<std::size_t, double>> shares;
    double all = 0;
    for (std::size_t c = 0; c < colliders.size(); ++c) {
        if (signed_distance(colliders[c], x, t) > 0) continue;
        const double share = std::max(1e-9 * J.norm(), J.dot(outward_normal(colliders[c], x, t)));
        shares.emplace_back(c, share), all += share;
    }
    for (const auto& [c, share] : shares) {
        if (!(all > 0)) continue;
        const Vec3d part = share / all * J;
        exchanges[c] += {colliders[c].velocity, -part, part.dot(colliders[c].velocity)};
    }
}

/// What a step does at the nodes, for the ledger.
struct NodeAccount {
    double before, after;               ///< Σ ½ m_i v_i² with vⁿ and with vⁿ⁺¹, as far as particles feel it [J].
    double gravity, contact;            ///< the works of both [J].
};

/// Nodes: (vⁿ⁺¹, m | vⁿ, 0). An impulse J does the work J·(vⁿ + vⁿ⁺¹)/2 on what it changes from vⁿ to vⁿ⁺¹ with others. What
/// bodies get is added to `exchanges`.
template <class Real>
NodeAccount account(const Grid<Real>& grid, const std::vector<FixedNode<Real>>& fixed, double dt, const Vec3d& g, Real flip_blend,
                    Real rest_speed, const std::vector<Collider>& colliders, double t, std::vector<Exchange>& exchanges) {
    using D4 = Pack<double, 4>;
    const auto of = [&](double m, const Vec3d& v, const Vec3d& v_new) {
        return D4::of(m / 2 * v.squaredNorm(), m / 2 * v_new.squaredNorm(), m * dt / 2 * g.dot(v + v_new), 0);
    };
    const auto before = [](const Node<Real>& n) { return Vec3d(n[4], n[5], n[6]); };
    const auto after = [](const Node<Real>& n) { return Vec3d(n[0], n[1], n[2]); };
    D4 sum = sum_over(static_cast<std::ptrdiff_t>(grid.size()), [&](std::ptrdiff_t i) {
        const Node<Real>& n = grid.nodes[i];
        return of(n[3], before(n), after(n));
    });
    NodeAccount a{};
    for (const FixedNode<Real>& f : fixed) {
        const Node<Real>& n = grid.nodes[f.node];
        const double m = n[3];
        const Vec3d v_n = f.v_n.template cast<double>(), unfelt = flip_share(n, flip_blend, rest_speed) * (v_n - before(n));
        const Vec3d v_new = after(n) + unfelt, J = f.impulse.template cast<double>() + m * unfelt;
        sum += of(m, v_n, v_new) - of(m, before(n), after(n));
        a.contact += J.dot(v_n + v_new) / 2;
        share_out(f.x, J, colliders, t, exchanges);
    }
    a.before = sum[0], a.after = sum[1], a.gravity = sum[2];
    return a;
}

}  // namespace firn
