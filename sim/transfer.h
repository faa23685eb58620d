#pragma once
#include "sim/arrangement.h"
#include "sim/rest.h"
#include "sim/snow.h"

namespace firn {

/// The materials of a group's particles, one a lane.
template <class Real>
SnowModel<Pack<Real, lanes>> models_of(const Particles<Real>& ps, const std::vector<SnowModel<Real>>& all,
                                       std::size_t group) {
    using P = Pack<Real, lanes>;
    const SnowModel<Real>& s = all[0];
    SnowModel<P> m{P(s.mu0), P(s.lambda0), P(s.xi), P(s.low), P(s.high), P(s.Jp_min)};
    if (!ps.several_materials) return m;
    for (int l = 0; l < lanes; ++l) {
        const SnowModel<Real>& own = all[ps.material[group * lanes + l]];
        m.mu0.lanes[l] = own.mu0, m.lambda0.lanes[l] = own.lambda0, m.xi.lanes[l] = own.xi;
        m.low.lanes[l] = own.low, m.high.lanes[l] = own.high, m.Jp_min.lanes[l] = own.Jp_min;
    }
    return m;
}

/// Where in the tile of their block the stencils of a group's particles begin.
template <class Real, Weights kind>
std::array<int, lanes> tile_corners(const Place<kind, Pack<Real, lanes>>& place, const ParticleBlock& b) {
    using P = Pack<Real, lanes>;
    Vec3<P> local;
    for (int a = 0; a < 3; ++a) local(a) = place.base(a) - P(Real(block_width * b.coordinates(a)));
    return integers(Tile<int, BSpline<kind>::width>::index(local(0), local(1), local(2)));
}

/// A group's particles on the nodes of their block: weights, and where in the block's tile their stencils begin. Under
/// APIC also the first moments m_k = w_k (x_k − x_p)/h, which sum to zero as the derivatives do.
template <class Real, Weights kind, Transfer transfer> struct Reach : Stencils<Real, kind> {
    using P = Pack<Real, lanes>;
    using N8 = Node<Real>;
    static constexpr int width = BSpline<kind>::width;
    static constexpr bool apic = transfer == Transfer::apic;
    std::array<int, lanes> at;
    P moment[3][apic ? width : 1];

    Reach(const Vec3<P>& x, const ParticleBlock& b, Real h) : Reach(Place<kind, P>(x, P(h)), b, h) {}

    /// Of particle l along an axis: the derivative for the upper half of a node, the moment for the lower one.
    N8 moment_and_slope(int axis, int k, int l) const {
        if constexpr (apic) return halves(N8(moment[axis][k][l]), N8(this->dN[axis][k][l]));
        else return N8(this->dN[axis][k][l]);
    }
    /// The derivative for the lower half, the moment for the upper one.
    N8 slope_and_moment(int axis, int k, int l) const {
        if constexpr (apic) return halves(N8(this->dN[axis][k][l]), N8(moment[axis][k][l]));
        else return N8(this->dN[axis][k][l]);
    }
    /// w_k along z becomes w_k + w_{k+1} + …, as a sloped tile needs it.
    void sum_up_z() {
        for (int k = width - 1; k > 1; --k) {
            this->N[2][k - 1] += this->N[2][k], this->dN[2][k - 1] += this->dN[2][k];
            if constexpr (apic) moment[2][k - 1] += moment[2][k];
        }
    }

private:
    Reach(const Place<kind, P>& place, const ParticleBlock& b, Real h)
        : Stencils<Real, kind>(place.t, h), at(tile_corners<Real, kind>(place, b)) {
        if constexpr (apic)
            for (int a = 0; a < 3; ++a)
                for (int k = 0; k < width; ++k) moment[a][k] = (P(Real(k)) - place.t(a)) * this->N[a][k];
    }
};

/// Steps 1 and 3 in one pass:  m_i = Σ_p m_p w_ip,  (m v)_i = Σ_p m_p v_p w_ip  (APIC: v_p + C_p (x_i − x_p)),
/// f_i = −Σ_p V_p⁰ P F_Eᵀ ∇w_ip, the report's (2) at x̂ = x; from lumps, what they remember of it.
template <Weights kind, Transfer transfer, class Real>
void rasterize_with_forces(Particles<Real>& ps, Grid<Real>& grid) {
    constexpr int width = BSpline<kind>::width;
    using P = Pack<Real, lanes>;
    using N8 = Node<Real>;
    grid.nodes.resize(grid.size());
    const auto n = static_cast<std::ptrdiff_t>(grid.size());
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i) grid.nodes[i] = N8(0);
    scatter_blocks(grid.blocks, [&](const ParticleBlock& b) {
        Tile<N8, width> tile;
        if (b.asleep() && !ps.lumps[b.lump].nodes.empty()) return add_lump(ps.lumps[b.lump], b, grid);
        tile.clear(grid.blocks, b);
        for (std::size_t k = 0; k < b.groups.size(); ++k) {
            const std::uint32_t g = b.groups[k], next = b.groups[std::min(k + 1, b.groups.size() - 1)];
            ps.x.prefetch(next), ps.v.prefetch(next), ps.tau.prefetch(next), ps.m.prefetch(next), ps.V0.prefetch(next);
            const Reach<Real, kind, transfer> r(vectors_of(ps.x, g), b, grid.h);
            const P m = ps.m.pack(g), V0 = ps.V0.pack(g);
            const auto f = [&](int i) { return -V0 * ps.tau.pack(g, i); };
            const auto mC = [&](int i) { return transfer == Transfer::apic ? P(m * P(grid.h) * ps.C.pack(g, i)) : P(0); };
            // What goes to a node: (m v, m | 0) w + Σ_a (m h C e_a, 0 | f e_a) ∂_a w.
            std::array<P, 8> plain{m * ps.v.pack(g, 0), m * ps.v.pack(g, 1), m * ps.v.pack(g, 2), m, P(0), P(0), P(0), P(0)};
            std::array<P, 8> along_x{mC(0), mC(1), mC(2), P(0), f(0), f(1), f(2), P(0)};
            std::array<P, 8> along_y{mC(3), mC(4), mC(5), P(0), f(1), f(3), f(4), P(0)};
            std::array<P, 8> along_z{mC(6), mC(7), mC(8), P(0), f(2), f(4), f(5), P(0)};
            transpose(plain), transpose(along_x), transpose(along_y), transpose(along_z);
            const int count = b.count_in(k);
#pragma GCC unroll 1  // a lane that is not known broadcasts from memory, which is what costs least
            for (int l = 0; l < count; ++l) {
                // Σ over a product of weights, taken apart axis by axis.
                N8 Nz[width], dNz[width];
                for (int c = 0; c < width; ++c) Nz[c] = N8(r.N[2][c][l]), dNz[c] = r.moment_and_slope(2, c, l);
                N8* corner = &tile.values[r.at[l]];
                for (int i = 0; i < width; ++i) {
                    const N8 N(r.N[0][i][l]);
                    const N8 of_x = N * plain[l] + r.moment_and_slope(0, i, l) * along_x[l];
                    const N8 of_y = N * along_y[l], of_z = N * along_z[l];
                    for (int j = 0; j < width; ++j) {
                        const N8 M(r.N[1][j][l]);
                        const N8 of_xy = M * of_x + r.moment_and_slope(1, j, l) * of_y, of_yz = M * of_z;
                        N8* row = corner + tile.index(i, j, 0);
                        for (int c = 0; c < width; ++c) row[c] = dNz[c] * of_yz + (Nz[c] * of_xy + row[c]);
                    }
                }
            }
        }
        if (!b.asleep()) return tile.add_to(grid.blocks, b, grid.nodes);
        remember(tile, grid.blocks, b, ps.lumps[b.lump]);
        add_lump(ps.lumps[b.lump], b, grid);
    });
}

/// Σ_i w_ip N_i of a particle and its derivatives in the lower halves; under APIC the upper half of a derivative is the
/// first moment Σ_i w_ip N_i (x_i − x_p)_a / h.
template <class Real> struct Interpolated { Node<Real> value, d[3]; };

/// Of particle l, whose weights along z are summed up.
template <class Real, Weights kind, Transfer transfer>
Interpolated<Real> interpolate(const SlopedTile<Node<Real>, BSpline<kind>::width>& tile, const Reach<Real, kind, transfer>& r, int l) {
    constexpr int width = BSpline<kind>::width;
    using N8 = Node<Real>;
    const N8 *nodes = &tile.nodes.values[r.at[l]], *steps = &tile.steps.values[r.at[l]];
    N8 Wz[width], dWz[width];
    for (int c = 1; c < width; ++c) Wz[c] = N8(r.N[2][c][l]), dWz[c] = r.slope_and_moment(2, c, l);
    Interpolated<Real> s{N8(0), {N8(0), N8(0), N8(0)}};
    for (int i = 0; i < width; ++i) {
        N8 value(0), dy(0), dz(0);
        for (int j = 0; j < width; ++j) {
            const int row = tile.nodes.index(i, j, 0);
            N8 sum = nodes[row], sum_dz(0);
            for (int c = 1; c < width; ++c) sum += Wz[c] * steps[row + c], sum_dz += dWz[c] * steps[row + c];
            const N8 M(r.N[1][j][l]);
            value += M * sum;
            dy += r.slope_and_moment(1, j, l) * sum;
            dz += M * sum_dz;
        }
        const N8 N(r.N[0][i][l]);
        s.value += N * value;
        s.d[0] += r.slope_and_moment(0, i, l) * value;
        s.d[1] += N * dy;
        s.d[2] += N * dz;
    }
    return s;
}

/// What a group's particles see of the nodes, a particle in each lane.
template <class Real> struct Seen {
    using P = Pack<Real, lanes>;
    Vec3<P> high;           ///< Σ_i w_ip of the nodes' upper halves,
    P share;                ///< and of their last numbers.
    Mat3<P> gradient;       ///< Σ_i low_i ∇w_ipᵀ
    Mat3<P> moment;         ///< APIC: Σ_i w_ip high_i (x_i − x_p)ᵀ / h
};
/// The weights along z are summed up.
template <class Real, Weights kind, Transfer transfer>
[[gnu::noinline]] Seen<Real> look(const SlopedTile<Node<Real>, BSpline<kind>::width>& tile, const Reach<Real, kind, transfer>& r, int count) {
    using N8 = Node<Real>;
    std::array<N8, lanes> a, b, c, d;
#pragma GCC unroll 1
    for (int l = count; l < lanes; ++l) a[l] = b[l] = c[l] = d[l] = N8(0);
#pragma GCC unroll 1
    for (int l = 0; l < count; ++l) {
        const Interpolated<Real> s = interpolate(tile, r, l);
        if constexpr (transfer == Transfer::apic) a[l] = s.value, b[l] = s.d[0], c[l] = s.d[1], d[l] = s.d[2];
        else a[l] = halves(s.d[0], s.value), b[l] = halves(s.d[1], exchanged(s.d[2]));
    }
    transpose(a), transpose(b);
    Seen<Real> seen;
    for (int i = 0; i < 3; ++i) seen.high(i) = a[4 + i];
    seen.share = a[7];
    if constexpr (transfer == Transfer::apic) {
        transpose(c), transpose(d);
        for (int i = 0; i < 3; ++i) {
            seen.gradient(i, 0) = b[i], seen.gradient(i, 1) = c[i], seen.gradient(i, 2) = d[i];
            seen.moment(i, 0) = b[4 + i], seen.moment(i, 1) = c[4 + i], seen.moment(i, 2) = d[4 + i];
        }
    } else {
        for (int i = 0; i < 3; ++i) seen.gradient(i, 0) = a[i], seen.gradient(i, 1) = b[i], seen.gradient(i, 2) = b[4 + i];
    }
    return seen;
}

/// Step 2:  ρ_p = Σ_i m_i w_ip / h³,  V_p⁰ = m_p / ρ_p, for particles that have no volume yet; m_p / ρ_p is the volume
/// now, J times V_p⁰, where J = det F_E J_P is not 1 at the start.
template <Weights kind, class Real> void set_volumes(Particles<Real>& ps, const Grid<Real>& grid) {
    gather_blocks<BSpline<kind>::width>(grid.blocks, grid.nodes, [&](std::size_t n, const auto& tile) {
        const ParticleBlock& b = grid.blocks.particle_blocks[n];
        for (std::size_t k = 0; k < b.groups.size(); ++k) {
            const std::uint32_t g = b.groups[k];
            const int count = b.count_in(k);
            Reach<Real, kind, Transfer::flip> r(vectors_of(ps.x, g), b, grid.h);
            r.sum_up_z();
            for (int l = 0; l < count; ++l) {
                const std::size_t slot = std::size_t(lanes) * g + l;
                const Real rho = interpolate(tile, r, l).value[3] / (grid.h * grid.h * grid.h);
                if (ps.V0.at(slot) > 0) continue;
                ps.V0.at(slot) = ps.m.at(slot) / rho / (determinant(matrix_of(ps.Fe, slot)) * ps.Jp.at(slot));
            }
        }
    });
}

}  // namespace firn
