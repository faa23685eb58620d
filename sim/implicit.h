#pragma once
#include "sim/conjugate_residual.h"
#include "sim/transfer.h"

namespace firn {

/// A vector at every node, for the linear solve.
template <class Real> struct NodeField {
    std::vector<NodeVector<Real>> at;

    void axpy(double a, const NodeField& y) {
        const auto n = static_cast<std::ptrdiff_t>(at.size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t i = 0; i < n; ++i) at[i] += NodeVector<Real>(Real(a)) * y.at[i];
    }
    void xpay(double a, const NodeField& y) {
        const auto n = static_cast<std::ptrdiff_t>(at.size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t i = 0; i < n; ++i) at[i] = y.at[i] + NodeVector<Real>(Real(a)) * at[i];
    }
};

/// Σ_i m_i a_i·b_i: sums of 64 nodes in doubles, added up in a fixed order.
template <class Real>
double mass_dot(const Grid<Real>& grid, const NodeField<Real>& a, const NodeField<Real>& b) {
    const auto blocks = static_cast<std::ptrdiff_t>(grid.blocks.grid_blocks.size());
    std::vector<double> partial(blocks);
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t block = 0; block < blocks; ++block) {
        double sum = 0;
        for (std::size_t n = block * block_nodes; n < std::size_t(block + 1) * block_nodes; ++n) {
            const NodeVector<Real> ab = a.at[n] * b.at[n];
            sum += double(grid.nodes[n][3]) * (double(ab[0]) + double(ab[1]) + double(ab[2]));
        }
        partial[block] = sum;
    }
    double sum = 0;
    for (double s : partial) sum += s;
    return sum;
}

/// A node at which contact fixed something, and the projector onto what it left free.
template <class Real> struct FixedNode {
    std::size_t node;
    Mat3<Real> free;
};

template <class Real> void project(const std::vector<FixedNode<Real>>& fixed, NodeField<Real>& u) {
    for (const FixedNode<Real>& f : fixed) {
        NodeVector<Real>& at = u.at[f.node];
        const Vec3<Real> a = f.free * Vec3<Real>(at[0], at[1], at[2]);
        at = NodeVector<Real>::of(a(0), a(1), a(2), 0);
    }
}

/// ∂²Φ/∂x² of all particles at F_Eⁿ with μ, λ frozen, matrix-free: the report's (3) and (4). What does not
/// change within a solve is computed once.
template <class Real, Weights kind> class Hessian {
public:
    using P = Pack<Real, lanes>;

    Hessian(const Particles<Real>& ps, const Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials)
        : ps_(ps), grid_(grid) {
        R_.resize(ps.n), K_.resize(ps.n), k_.resize(ps.n), A_.resize(ps.n);
        const auto groups = static_cast<std::ptrdiff_t>((ps.n + lanes - 1) / lanes);
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t g = 0; g < groups; ++g) {
            const Decomposition<P> d = decompose(matrices_of(ps.Fe, g));
            const Mat3<P> S = d.V * d.s.asDiagonal() * d.V.transpose();
            const Lame<P> k = hardened(models_of(ps, materials, g), ps.Jp.pack(g));
            store(R_, g, d.rotation());
            store(K_, g, upper_triangle(rotation_system_inverse(S)));
            k_.pack(g, 0) = ps.V0.pack(g) * k.mu, k_.pack(g, 1) = ps.V0.pack(g) * k.lambda;
        }
    }

    /// (∂²Φ/∂x² u)_i = Σ_p V_p⁰ A_p F_Eᵀ ∇w_ip with A_p = ∂²Ψ/∂F_E∂F_E : Σ_j u_j ∇w_jpᵀ F_E.
    NodeField<Real> operator()(const NodeField<Real>& u) const {
        constexpr int width = BSpline<kind>::width;
        using N4 = NodeVector<Real>;
        gather_groups<width>(grid_.blocks, ps_.n, u.at, [&](std::size_t g, auto& tile_of) {
            Mat3<P> gradient = Mat3<P>::Zero();
            for (std::size_t p = g * lanes; p < std::min((g + 1) * lanes, ps_.n); ++p) {
                const auto [tile, block] = tile_of(p);
                const Stencil<Real, kind> s(vector_of(ps_.x, p), grid_.h);
                const Interpolated<N4> i = interpolate<kind, Transfer::flip>(tile, block, s);
                for (int c = 0; c < 9; ++c) gradient(c).lanes[p % lanes] = i.d[c / 3][c % 3];
            }
            const Mat3<P> F = matrices_of(ps_.Fe, g), dF = gradient * F;
            Mat3<P> K;
            K << K_.pack(g, 0), K_.pack(g, 1), K_.pack(g, 2), K_.pack(g, 1), K_.pack(g, 3), K_.pack(g, 4),
                K_.pack(g, 2), K_.pack(g, 4), K_.pack(g, 5);
            const Mat3<P> dR = rotation_differential(matrices_of(R_, g), K, dF);
            const Lame<P> k{k_.pack(g, 0), k_.pack(g, 1)};
            store(A_, g, Mat3<P>(stress_differential(F, dR, k, dF) * F.transpose()));
        });
        NodeField<Real> f;
        f.at.assign(grid_.size(), N4(0));
        scatter_blocks<width>(grid_.blocks, f.at, [&](const ParticleBlock& b, auto& tile) {
            for (std::uint32_t p = b.begin; p < b.end; ++p) {
                const Stencil<Real, kind> s(vector_of(ps_.x, p), grid_.h);
                const Vec3i at = s.base - block_width * b.coordinates;
                const auto column = [&](int c) {
                    return N4::of(A_.at(p, 3 * c), A_.at(p, 3 * c + 1), A_.at(p, 3 * c + 2), 0); };
                const N4 x = column(0), y = column(1), z = column(2);
                for (int i = 0; i < width; ++i) {
                    const N4 of_x = N4(s.dN[0][i]) * x, of_y = N4(s.N[0][i]) * y, of_z = N4(s.N[0][i]) * z;
                    for (int j = 0; j < width; ++j) {
                        const N4 of_xy = N4(s.N[1][j]) * of_x + N4(s.dN[1][j]) * of_y;
                        const N4 of_yz = N4(s.N[1][j]) * of_z;
                        N4* row = &tile.values[tile.index(at(0) + i, at(1) + j, at(2))];
                        for (int m = 0; m < width; ++m) row[m] += N4(s.N[2][m]) * of_xy + N4(s.dN[2][m]) * of_yz;
                    }
                }
            }
        });
        return f;
    }

private:
    const Particles<Real>& ps_;
    const Grid<Real>& grid_;
    Field<Real, 9> R_;          ///< rotation of F_E.
    Field<Real, 6> K_;          ///< (tr S · I − S)⁻¹.
    Field<Real, 2> k_;          ///< V⁰ μ and V⁰ λ, hardened [J].
    mutable Field<Real, 9> A_;  ///< V⁰ A_p F_Eᵀ of the product under way [J].
};

/// Step 6:  (M + β Δt² ∂²Φ/∂x²) vⁿ⁺¹ = M v*, the paper's equation times M, solved for vⁿ⁺¹ − v* by conjugate
/// residuals in M's dot product; what contact fixed keeps its v*. The nodes hold v* and m, afterwards vⁿ⁺¹.
template <Weights kind, class Real>
Convergence solve(const Particles<Real>& ps, Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials,
                  const std::vector<FixedNode<Real>>& fixed, Real dt, const Solver& solver) {
    using N4 = NodeVector<Real>;
    const Hessian<Real, kind> hessian(ps, grid, materials);
    const auto n = static_cast<std::ptrdiff_t>(grid.size());
    const Real factor = Real(solver.beta) * dt * dt;

    // β Δt² M⁻¹ ∂²Φ/∂x² u, in the directions that are free.
    const auto stiffness = [&](const NodeField<Real>& u) {
        NodeField<Real> f = hessian(u);
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t i = 0; i < n; ++i)
            f.at[i] *= N4(grid.nodes[i][3] > 0 ? factor / grid.nodes[i][3] : Real(0));
        project(fixed, f);
        return f;
    };
    const auto E = [&](const NodeField<Real>& u) {
        NodeField<Real> Eu = stiffness(u);
        Eu.axpy(1, u);
        return Eu;
    };
    const auto dot = [&](const NodeField<Real>& a, const NodeField<Real>& b) { return mass_dot(grid, a, b); };

    NodeField<Real> v_star, dv;
    v_star.at.resize(n), dv.at.assign(n, N4(0));
    for (std::ptrdiff_t i = 0; i < n; ++i)
        v_star.at[i] = N4::of(grid.nodes[i][0], grid.nodes[i][1], grid.nodes[i][2], 0);
    NodeField<Real> b = stiffness(v_star);
    for (N4& b_i : b.at) b_i = -b_i;
    const double floor = 4 * std::numeric_limits<Real>::epsilon() * std::sqrt(dot(v_star, v_star));
    const Convergence c = conjugate_residual(dv, b, E, dot, solver.tolerance, floor, solver.max_iterations);
    for (std::ptrdiff_t i = 0; i < n; ++i)
        for (int a = 0; a < 3; ++a) grid.nodes[i].lanes[a] += dv.at[i][a];
    return c;
}

}  // namespace firn
