#pragma once
#include "sim/collision.h"
#include "sim/implicit.h"
#include "sim/transfer.h"

#include <omp.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <optional>

namespace firn {

/// Step 4:  v_i = (m v)_i / m_i,  v*_i = v_i + Δt (f_i / m_i + g). Nodes: (m v, m | f, 0) → (v*, m | v, 0).
template <class Real> void accelerate(Grid<Real>& grid, Real dt, const Vec3<Real>& gravity) {
    const auto n = static_cast<std::ptrdiff_t>(grid.size());
    const Node<Real> g = Node<Real>::of(gravity(0), gravity(1), gravity(2), 0, 0, 0, 0, 0);
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        const Node<Real> node = grid.nodes[i];
        const Real m = node[3];
        if (!(m > 0)) { grid.nodes[i] = Node<Real>(0); continue; }
        const Node<Real> v = node / Node<Real>(m);           // (v, 1 | f/m, 0)
        const Node<Real> a = Node<Real>::of(v[4], v[5], v[6], 0, 0, 0, 0, 0) + g;
        Node<Real> r = v + Node<Real>(dt) * a;
        grid.nodes[i] = Node<Real>::of(r[0], r[1], r[2], m, v[0], v[1], v[2], 0);
    }
}

/// Step 5: v* of the nodes against the bodies. Returns the nodes where contact fixed something. `fall`, Δt g, tells what
/// stresses gave to v* alone.
template <class Real>
std::vector<FixedNode<Real>> collide_nodes(Grid<Real>& grid, const std::vector<Collider>& colliders, double t, NodeContact law, double flip_blend,
                                           const std::optional<Vec3d>& fall = {}) {
    std::vector<FixedNode<Real>> fixed;
    if (colliders.empty()) return fixed;
    const double h = grid.h;
    std::vector<std::vector<FixedNode<Real>>> parts(omp_get_max_threads());   // whose blocks follow each other
    const auto count = static_cast<std::ptrdiff_t>(grid.blocks.grid_blocks.size());
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t n = 0; n < count; ++n) {
        const GridBlock& b = grid.blocks.grid_blocks[n];
        const Vec3d center = h * (block_width * b.coordinates.cast<double>() + Vec3d::Constant(1.5));
        if (!near(colliders, center, 1.5 * std::sqrt(3.0) * h * (1 + 1e-9), t)) continue;
        std::uint32_t i = b.first;
        for (NodeSet left = b.nodes; left != 0; left &= left - 1, ++i) {
            Node<Real>& node = grid.nodes[i];
            if (!(node[3] > 0)) continue;
            const Vec3d x = grid.position(b, std::countr_zero(left));
            const Vec3d v_star(node[0], node[1], node[2]), v_n(node[4], node[5], node[6]);
            NodeCollided c;
            if (law == NodeContact::elastic) {
                Vec3d pressed = fall ? Vec3d(v_star - v_n - *fall) : Vec3d(0, 0, 0);
                if (pressed.norm() < 8 * std::numeric_limits<Real>::epsilon() * (v_n.norm() + v_star.norm())) pressed.setZero();
                c = collide_elastic(x, {v_n, v_star, pressed, flip_blend}, colliders, t);
            } else {
                c = {collide(x, v_star, colliders, t), v_n};
            }
            if (!c.touched) continue;
            for (int a = 0; a < 3; ++a) node.lanes[a] = Real(c.v(a)), node.lanes[4 + a] = Real(c.before(a));
            const Vec3d impulse = double(node[3]) * (c.v - v_star);
            parts[omp_get_thread_num()].push_back({i, c.free.template cast<Real>(), v_n.template cast<Real>(), impulse.template cast<Real>(), x});
        }
    }
    for (const auto& part : parts) fixed.insert(fixed.end(), part.begin(), part.end());
    return fixed;
}

/// Contact after contact: the impulses add up, and vⁿ is what it was before the first.
template <class Real> void add_impulses(std::vector<FixedNode<Real>>& fixed, const std::vector<FixedNode<Real>>& more) {
    fixed.insert(fixed.end(), more.begin(), more.end());
    std::stable_sort(fixed.begin(), fixed.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
    std::size_t kept = 0;
    for (std::size_t n = 0; n < fixed.size(); ++n) {
        if (kept > 0 && fixed[kept - 1].node == fixed[n].node) fixed[kept - 1].impulse += fixed[n].impulse;
        else fixed[kept++] = fixed[n];
    }
    fixed.resize(kept);
}

/// After step 6: (vⁿ⁺¹, m | vⁿ, 0) → (vⁿ⁺¹, m | vⁿ⁺¹ − α vⁿ, α), so that a particle's new FLIP velocity is α v_p and one
/// sum. α is FLIP's share, 0 of nodes slower than `rest_speed`, and under APIC, which makes two sums of vⁿ⁺¹.
template <class Real> void finish_nodes(Grid<Real>& grid, Real flip_blend, Real rest_speed) {
    const auto n = static_cast<std::ptrdiff_t>(grid.size());
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        Node<Real>& v = grid.nodes[i];
        const Real share = flip_share(v, flip_blend, rest_speed);
        v = Node<Real>::of(v[0], v[1], v[2], v[3], v[0] - share * v[4], v[1] - share * v[5], v[2] - share * v[6], share);
    }
}

/// A particle whose step goes wrong: its deformation could turn inside out, or is not a number.
struct Offender {
    std::uint32_t id;
    double value;           ///< ‖Δt ∇v‖
};

/// Looks for particles that vⁿ⁺¹ could invert: ‖Δt ∇v‖ ≥ 1, short of which det(I + Δt ∇v) > 0. Blocks whose nodes
/// move nearly alike are passed over: ‖∇v‖ is at most half the spread of the velocities times Σ_i ‖∇w_ip‖, which
/// is 6/h at the most.
template <Weights kind, class Real>
std::vector<Offender> inverted(const Particles<Real>& ps, const Grid<Real>& grid, Real dt) {
    std::vector<Offender> offenders;
    const auto count = static_cast<std::ptrdiff_t>(grid.blocks.particle_blocks.size());
#pragma omp parallel for schedule(dynamic)
    for (std::ptrdiff_t c = 0; c < count; ++c) {
        const ParticleBlock& b = grid.blocks.particle_blocks[c];
        if (b.asleep()) continue;
        SlopedTile<Node<Real>, BSpline<kind>::width> tile;
        constexpr Real huge = std::numeric_limits<Real>::max();
        Node<Real> low(huge), high(-huge);
        bool finite = true;
        tile.nodes.for_each(grid.blocks, b, [&](Node<Real>&, std::uint32_t n) {
            const Node<Real>& v = grid.nodes[n];
            if (!(v[3] > 0)) return;
            low = minimum(low, v), high = maximum(high, v);
            for (int a = 0; a < 3; ++a) finite &= std::isfinite(v[a]);
        });
        const Node<Real> spread = high - low;
        const Real norm = std::sqrt(spread[0] * spread[0] + spread[1] * spread[1] + spread[2] * spread[2]);
        if (finite && dt * norm * 3 / grid.h < 1) continue;
        tile.load(grid.blocks, b, grid.nodes);
        for (std::size_t k = 0; k < b.groups.size(); ++k) {
            const std::uint32_t g = b.groups[k];
            const int held = b.count_in(k);
            Reach<Real, kind, Transfer::flip> r(vectors_of(ps.x, g), b, grid.h);
            r.sum_up_z();
            const Seen<Real> seen = look(tile, r, held);
            for (int l = 0; l < held; ++l) {
                Mat3<Real> gradient;
                for (int i = 0; i < 9; ++i) gradient(i) = seen.gradient(i)[l];
                const Real value = dt * gradient.norm();
                if (value < 1) continue;
#pragma omp critical
                offenders.push_back({ps.id[std::size_t(lanes) * g + l], double(value)});
            }
        }
    }
    return offenders;
}

}  // namespace firn
