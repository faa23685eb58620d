#pragma once
#include "sim/grid.h"
#include "sim/snow.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace firn {

/// The materials of a group's particles, one a lane.
template <class Real>
SnowModel<Pack<Real, lanes>> models_of(const Particles<Real>& ps, const std::vector<SnowModel<Real>>& all,
                                       std::size_t group) {
    using P = Pack<Real, lanes>;
    const SnowModel<Real>& s = all[0];
    SnowModel<P> m{P(s.mu0), P(s.lambda0), P(s.xi), P(s.low), P(s.high), P(s.Jp_min)};
    if (ps.material.empty()) return m;
    for (std::size_t p = group * lanes; p < std::min((group + 1) * lanes, ps.n); ++p) {
        const SnowModel<Real>& own = all[ps.material[p]];
        const int l = p % lanes;
        m.mu0.lanes[l] = own.mu0, m.lambda0.lanes[l] = own.lambda0, m.xi.lanes[l] = own.xi;
        m.low.lanes[l] = own.low, m.high.lanes[l] = own.high, m.Jp_min.lanes[l] = own.Jp_min;
    }
    return m;
}

/// Stretches of consecutive particles with their base nodes in one block (input of `arrange`).
/// Throws std::out_of_range with the number of the first particle that is nowhere: NaN, beyond 2·10⁹ nodes, or so
/// far out that Real does not tell sixteenths of a cell apart.
template <Weights kind, class Real> std::vector<Run> runs(const Particles<Real>& ps, Real h) {
    constexpr std::ptrdiff_t chunk = 4096;
    constexpr Real farthest = sizeof(Real) == 4 ? Real(1 << 20) : Real(2e9);
    const auto n = static_cast<std::ptrdiff_t>(ps.n), chunks = (n + chunk - 1) / chunk;
    std::vector<std::vector<Run>> parts(chunks);
    std::ptrdiff_t lost = n;
#pragma omp parallel for schedule(static) reduction(min : lost)
    for (std::ptrdiff_t c = 0; c < chunks; ++c) {
        std::vector<Run>& part = parts[c];
        for (auto p = c * chunk; p < std::min((c + 1) * chunk, n); ++p) {
            Vec3<Real> base;
            for (int a = 0; a < 3; ++a) base(a) = BSpline<kind>::base(ps.x.at(p, a) / h);
            if (!(base.cwiseAbs().maxCoeff() < farthest) || base.hasNaN()) { lost = std::min(lost, p); break; }
            const Vec3i block(int(base(0)) >> 2, int(base(1)) >> 2, int(base(2)) >> 2);
            const auto index = static_cast<std::uint32_t>(p);
            if (part.empty() || part.back().block != block) part.push_back({block, index, index, 0});
            ++part.back().end;
            part.back().bases |= node_bit(int(base(0)) & 3, int(base(1)) & 3, int(base(2)) & 3);
        }
    }
    if (lost < n) throw std::out_of_range(std::to_string(lost));
    std::vector<Run> all;
    for (const std::vector<Run>& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// Steps 1 and 3 in one pass:  m_i = Σ_p m_p w_ip,  (m v)_i = Σ_p m_p v_p w_ip  (APIC: v_p + C_p (x_i − x_p)),
/// f_i = −Σ_p V_p⁰ P F_Eᵀ ∇w_ip, the report's (2) at x̂ = x.
template <Weights kind, Transfer transfer, class Real>
void rasterize_with_forces(const Particles<Real>& ps, Grid<Real>& grid) {
    constexpr int width = BSpline<kind>::width;
    using N8 = Node<Real>;
    grid.nodes.assign(grid.size(), N8(0));
    scatter_blocks<width>(grid.blocks, grid.nodes, [&](const ParticleBlock& b, auto& tile) {
        const Vec3i origin = block_width * b.coordinates;
        for (std::uint32_t p = b.begin; p < b.end; ++p) {
            const Stencil<Real, kind> s(vector_of(ps.x, p), grid.h);
            const Vec3i at = s.base - origin;
            const Real m = ps.m.at(p), V0 = ps.V0.at(p);
            const Mat3<Real> f = -V0 * ps.stress(p);  // times ∇w_ip
            Vec3<Real> mv = m * vector_of(ps.v, p);
            Mat3<Real> mC;                            // momentum per node along each axis
            if constexpr (transfer == Transfer::apic) {
                mC = m * grid.h * matrix_of(ps.C, p);
                mv -= mC * Vec3<Real>(s.t[0], s.t[1], s.t[2]);
            }
            const auto node = [](const Vec3<Real>& low, Real m_i, const Vec3<Real>& high) {
                return N8::of(low(0), low(1), low(2), m_i, high(0), high(1), high(2), 0); };
            const Vec3<Real> none(0, 0, 0);
            const N8 momentum = node(mv, m, none);
            const N8 fx = node(none, 0, f.col(0)), fy = node(none, 0, f.col(1)), fz = node(none, 0, f.col(2));

            // Σ over a product of weights, taken apart axis by axis; along z, momentum and force share a number.
            N8 Nz[width], dNz[width];
            for (int k = 0; k < width; ++k) {
                Nz[k] = N8(s.N[2][k]), dNz[k] = N8(s.dN[2][k]);
                if constexpr (transfer == Transfer::apic) {
                    const Real z = Real(k) * s.N[2][k], d = s.dN[2][k];
                    dNz[k] = N8::of(z, z, z, 0, d, d, d, 0);
                }
            }
            for (int i = 0; i < width; ++i) {
                N8 of_x = N8(s.N[0][i]) * momentum + N8(s.dN[0][i]) * fx;
                const N8 of_y = N8(s.N[0][i]) * fy;
                N8 of_z = fz;
                if constexpr (transfer == Transfer::apic) {
                    of_x += N8(Real(i) * s.N[0][i]) * node(mC.col(0), 0, none);
                    of_z += node(mC.col(2), 0, none);
                }
                of_z *= N8(s.N[0][i]);
                for (int j = 0; j < width; ++j) {
                    N8 of_xy = N8(s.N[1][j]) * of_x + N8(s.dN[1][j]) * of_y;
                    if constexpr (transfer == Transfer::apic)
                        of_xy += N8(Real(j) * s.N[1][j] * s.N[0][i]) * node(mC.col(1), 0, none);
                    const N8 of_yz = N8(s.N[1][j]) * of_z;
                    N8* row = &tile.values[tile.index(at(0) + i, at(1) + j, at(2))];
                    for (int k = 0; k < width; ++k) row[k] += Nz[k] * of_xy + dNz[k] * of_yz;
                }
            }
        }
    });
}

/// Σ_i w_ip N_i of a particle and its derivatives; under APIC the upper half of a derivative is the first
/// moment Σ_i w_ip N_i (x_i − x_p)_a / h instead.
template <class Value> struct Interpolated { Value value, d[3]; };

template <Weights kind, Transfer transfer, class Real, class Value>
Interpolated<Value> interpolate(const Tile<Value, BSpline<kind>::width>& tile, const ParticleBlock& b,
                                const Stencil<Real, kind>& s) {
    constexpr int width = BSpline<kind>::width;
    const Vec3i at = s.base - block_width * b.coordinates;
    Value d[3][width];
    for (int a = 0; a < 3; ++a)
        for (int k = 0; k < width; ++k) {
            d[a][k] = Value(s.dN[a][k]);
            if constexpr (transfer == Transfer::apic) {
                const Real g = s.dN[a][k], moment = (Real(k) - s.t[a]) * s.N[a][k];
                d[a][k] = Value::of(g, g, g, 0, moment, moment, moment, 0);
            }
        }
    Interpolated<Value> r{Value(0), {Value(0), Value(0), Value(0)}};
    for (int i = 0; i < width; ++i) {
        Value value(0), dy(0), dz(0);
        for (int j = 0; j < width; ++j) {
            const Value* row = &tile.values[tile.index(at(0) + i, at(1) + j, at(2))];
            Value sum(0), sum_dz(0);
            for (int k = 0; k < width; ++k) sum += Value(s.N[2][k]) * row[k], sum_dz += d[2][k] * row[k];
            value += Value(s.N[1][j]) * sum;
            dy += d[1][j] * sum;
            dz += Value(s.N[1][j]) * sum_dz;
        }
        r.value += Value(s.N[0][i]) * value;
        r.d[0] += d[0][i] * value;
        r.d[1] += Value(s.N[0][i]) * dy;
        r.d[2] += Value(s.N[0][i]) * dz;
    }
    return r;
}

/// Step 2:  ρ_p = Σ_i m_i w_ip / h³,  V_p⁰ = m_p / ρ_p, for particles that have no volume yet.
template <Weights kind, class Real> void set_volumes(Particles<Real>& ps, const Grid<Real>& grid) {
    gather_groups<BSpline<kind>::width>(grid.blocks, ps.n, grid.nodes, [&](std::size_t group, auto& tile_of) {
        for (std::size_t p = group * lanes; p < std::min((group + 1) * lanes, ps.n); ++p) {
            if (ps.V0.at(p) > 0) continue;
            const auto [tile, block] = tile_of(p);
            const Stencil<Real, kind> s(vector_of(ps.x, p), grid.h);
            const Real m = interpolate<kind, Transfer::flip>(tile, block, s).value[3];
            ps.V0.at(p) = ps.m.at(p) / (m / (grid.h * grid.h * grid.h));
        }
    });
}

}  // namespace firn
