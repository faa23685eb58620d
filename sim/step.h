#pragma once
#include "sim/collision.h"
#include "sim/implicit.h"
#include "sim/transfer.h"
#include "sim/simulation.h"

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

/// Whether any collider comes within `radius` of x [m].
inline bool near(const std::vector<Collider>& colliders, const Vec3d& x, double radius, double t) {
    return std::any_of(colliders.begin(), colliders.end(),
                       [&](const Collider& c) { return signed_distance(c, x, t) <= radius; });
}

/// Step 5: v* of the nodes against the bodies. Returns the nodes where contact fixed something. With `fall`, Δt g, what
/// meets the bodies is v + Δt g, and friction sees how the forces in v* press it there: in a long step their tangential
/// part is no motion that a body could feel.
template <class Real>
std::vector<FixedNode<Real>> collide_nodes(Grid<Real>& grid, const std::vector<Collider>& colliders, double t,
                                           const std::optional<Vec3d>& fall = {}) {
    std::vector<FixedNode<Real>> fixed;
    if (colliders.empty()) return fixed;
    const double h = grid.h;
    for (const GridBlock& b : grid.blocks.grid_blocks) {
        const Vec3d center = h * (block_width * b.coordinates.cast<double>() + Vec3d::Constant(1.5));
        if (!near(colliders, center, 1.5 * std::sqrt(3.0) * h * (1 + 1e-9), t)) continue;
        std::uint32_t i = b.first;
        for (NodeSet left = b.nodes; left != 0; left &= left - 1, ++i) {
            Node<Real>& node = grid.nodes[i];
            if (!(node[3] > 0)) continue;
            const Vec3d x = grid.position(b, std::countr_zero(left));
            Vec3d v(node[0], node[1], node[2]), push(0, 0, 0);
            if (fall) push = v, v = Vec3d(node[4], node[5], node[6]) + *fall, push -= v;
            const Collided c = collide(x, v, colliders, t, push);
            if (!c.touched) continue;
            for (int a = 0; a < 3; ++a) node.lanes[a] = Real(c.v(a));
            fixed.push_back({i, c.free.template cast<Real>()});
        }
    }
    return fixed;
}

/// After step 6, under APIC: (vⁿ⁺¹, m | …) → (vⁿ⁺¹, m | vⁿ⁺¹, 0), for the two sums that it makes of vⁿ⁺¹.
template <Transfer transfer, class Real> void finish_nodes(Grid<Real>& grid) {
    if constexpr (transfer == Transfer::apic)
        for (Node<Real>& n : grid.nodes) n = Node<Real>::of(n[0], n[1], n[2], n[3], n[0], n[1], n[2], 0);
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
        Tile<Node<Real>, BSpline<kind>::width> tile;
        constexpr Real huge = std::numeric_limits<Real>::max();
        Node<Real> low(huge), high(-huge);
        bool finite = true;
        tile.for_each(grid.blocks, b, [&](Node<Real>& v, std::uint32_t n) {
            v = grid.nodes[n];
            if (!(v[3] > 0)) return;
            low = minimum(low, v), high = maximum(high, v);
            for (int a = 0; a < 3; ++a) finite &= std::isfinite(v[a]);
        });
        const Node<Real> spread = high - low;
        const Real norm = std::sqrt(spread[0] * spread[0] + spread[1] * spread[1] + spread[2] * spread[2]);
        if (finite && dt * norm * 3 / grid.h < 1) continue;
        for (std::uint32_t p = b.begin; p < b.end; ++p) {
            const Stencil<Real, kind> s(vector_of(ps.x, p), grid.h);
            const Interpolated<Node<Real>> i = interpolate<kind, Transfer::flip>(tile, b, s);
            Mat3<Real> gradient;
            for (int k = 0; k < 9; ++k) gradient(k) = i.d[k / 3][k % 3];
            const Real value = dt * gradient.norm();
            if (value < 1) continue;
#pragma omp critical
            offenders.push_back({ps.id[p], double(value)});
        }
    }
    return offenders;
}

/// Largest values over all particles after a step, which bound the next Δt, and their energy.
struct Extremes {
    double speed = 0;       ///< |v_p| [m/s]
    double wave = 0;        ///< speed of sound √((λ + 2μ) V⁰ / m), hardened [m/s]
    double strain_rate = 0; ///< ‖∇v_p‖ [1/s]
    double energy = 0;      ///< Σ ½ m v² + V⁰ Ψ [J]
    double height = 0;      ///< Σ m g·x [J]: what gravity has given.
    void include(const Extremes& e) {
        speed = std::max(speed, e.speed), wave = std::max(wave, e.wave), strain_rate = std::max(strain_rate, e.strain_rate);
        energy += e.energy, height += e.height;
    }
};

/// What steps 7 to 10 need besides particles and nodes.
template <class Real> struct Motion {
    Real dt, flip_blend;
    Vec3<Real> gravity;
    const std::vector<SnowModel<Real>>& materials;
    const std::vector<Collider>& colliders;
    double t;
};

/// Steps 7 to 10 in one pass over the particles:
///   7  ∇v_p = Σ_i v_iⁿ⁺¹ ∇w_ipᵀ,  F̂_E = (I + Δt ∇v_p) F_E,  return mapping
///   8  v_p ← (1−α) Σ_i v_iⁿ⁺¹ w_ip + α (v_p + Σ_i (v_iⁿ⁺¹ − v_iⁿ) w_ip)
///      APIC: v_p = Σ_i v_iⁿ⁺¹ w_ip,  C_p = Σ_i w_ip v_iⁿ⁺¹ (x_i − x_p)ᵀ / D
///   9  v_p against the bodies, at x_pⁿ
///  10  x_p ← x_p + Δt v_p
template <Weights kind, Transfer transfer, class Real>
Extremes advance(Particles<Real>& ps, const Grid<Real>& grid, const Motion<Real>& motion) {
    using P = Pack<Real, lanes>;
    constexpr int width = BSpline<kind>::width;
    const double h = grid.h;
    std::vector<Extremes> extremes(ps.n / lanes / groups_per_chunk + 1);
    gather_groups<width>(grid.blocks, ps.n, grid.nodes, [&](std::size_t g, auto& tile_of) {
        const int count = static_cast<int>(std::min<std::size_t>(lanes, ps.n - g * lanes));
        Mat3<P> gradient = Mat3<P>::Zero(), moment = Mat3<P>::Zero();
        Vec3<P> v_new = Vec3<P>::Zero(), v_old = Vec3<P>::Zero();
        bool contact = false;
        for (int l = 0; l < count; ++l) {
            const auto [tile, block] = tile_of(g * lanes + l);
            const Stencil<Real, kind> s(vector_of(ps.x, g * lanes + l), grid.h);
            const Interpolated<Node<Real>> i = interpolate<kind, transfer>(tile, block, s);
            for (int a = 0; a < 3; ++a) v_new(a).lanes[l] = i.value[a], v_old(a).lanes[l] = i.value[4 + a];
            for (int k = 0; k < 9; ++k) {
                gradient(k).lanes[l] = i.d[k / 3][k % 3];
                moment(k).lanes[l] = i.d[k / 3][4 + k % 3];
            }
        }
        const P dt(motion.dt), blend(motion.flip_blend);
        const Mat3<P> F_trial = matrices_of(ps.Fe, g) + dt * gradient * matrices_of(ps.Fe, g);
        const Returned<P> r = return_map(models_of(ps, motion.materials, g), F_trial, ps.Jp.pack(g));
        store(ps.Fe, g, r.Fe);
        ps.Jp.pack(g) = r.Jp;
        store(ps.tau, g, upper_triangle(r.tau));

        Vec3<P> v = v_new;
        if constexpr (transfer == Transfer::apic)
            store(ps.C, g, Mat3<P>(moment * P(Real(1 / (BSpline<kind>::second_moment * h)))));
        else
            v = (P(1) - blend) * v_new + blend * (vectors_of(ps.v, g) + v_new - v_old);

        const Vec3<P> x = vectors_of(ps.x, g);
        if (!motion.colliders.empty()) {
            Vec3d low = Vec3d::Constant(1e300), high = -low;
            for (int l = 0; l < count; ++l) {
                const Vec3d x_l(x(0)[l], x(1)[l], x(2)[l]);
                low = low.cwiseMin(x_l), high = high.cwiseMax(x_l);
            }
            contact = near(motion.colliders, (low + high) / 2, (high - low).norm() / 2 * (1 + 1e-9), motion.t);
        }
        for (int l = 0; contact && l < count; ++l) {
            const Vec3d v_l = collide(Vec3d(x(0)[l], x(1)[l], x(2)[l]), Vec3d(v(0)[l], v(1)[l], v(2)[l]),
                                      motion.colliders, motion.t).v;
            for (int a = 0; a < 3; ++a) v(a).lanes[l] = Real(v_l(a));
        }
        store(ps.v, g, v);
        const Vec3<P> x_new = x + dt * v;
        store(ps.x, g, x_new);

        const P m = ps.m.pack(g), V0 = ps.V0.pack(g), speed2 = v.squaredNorm(), rate2 = gradient.squaredNorm();
        const P wave2 = (r.k.lambda + P(2) * r.k.mu) * V0 / m, energy = m * speed2 / P(2) + V0 * r.energy_density;
        const P height = m * (P(motion.gravity(0)) * x_new(0) + P(motion.gravity(1)) * x_new(1) + P(motion.gravity(2)) * x_new(2));
        Extremes& e = extremes[g / groups_per_chunk];
        for (int l = 0; l < count; ++l)
            e.include({double(speed2[l]), double(wave2[l]), double(rate2[l]), double(energy[l]), double(height[l])});
    });
    Extremes all;
    for (const Extremes& e : extremes) all.include(e);
    all.speed = std::sqrt(all.speed), all.wave = std::sqrt(all.wave), all.strain_rate = std::sqrt(all.strain_rate);
    return all;
}

}  // namespace firn
