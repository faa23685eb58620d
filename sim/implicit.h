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
/// change within a solve is computed once, and lies in the order in which it is used: eight particles of one
/// block at a time.
template <class Real, Weights kind> class Hessian {
public:
    using P = Pack<Real, lanes>;
    static constexpr int width = BSpline<kind>::width;

    Hessian(const Particles<Real>& ps, const Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials)
        : grid_(grid) {
        const std::vector<ParticleBlock>& blocks = grid.blocks.particle_blocks;
        for (const ParticleBlock& b : blocks) {
            first_.push_back(elements_.size());
            elements_.resize(elements_.size() + (b.end - b.begin + lanes - 1) / lanes);
        }
        const auto count = static_cast<std::ptrdiff_t>(blocks.size());
#pragma omp parallel for schedule(dynamic)
        for (std::ptrdiff_t i = 0; i < count; ++i)
            for (std::uint32_t p = blocks[i].begin; p < blocks[i].end; p += lanes)
                elements_[first_[i] + (p - blocks[i].begin) / lanes] = element(ps, blocks[i], p, materials);
    }

    /// (∂²Φ/∂x² u)_i = Σ_p V_p⁰ A_p F_Eᵀ ∇w_ip with A_p = ∂²Ψ/∂F_E∂F_E : Σ_j u_j ∇w_jpᵀ F_E.
    NodeField<Real> operator()(const NodeField<Real>& u) const {
        using N4 = NodeVector<Real>;
        NodeField<Real> f;
        f.at.assign(grid_.size(), N4(0));
        scatter_blocks<width>(grid_.blocks, f.at, [&](const ParticleBlock& b, Tile<N4, width>& out) {
            Tile<N4, width> in;
            in.load(b, u.at);
            const std::size_t first = first_[&b - grid_.blocks.particle_blocks.data()];
            for (std::uint32_t p = b.begin; p < b.end; p += lanes) {
                const Element& e = elements_[first + (p - b.begin) / lanes];
                Mat3<P> gradient = Mat3<P>::Zero();
                for (int l = 0; l < e.count; ++l) e.gather(in, l, gradient);
                const Mat3<P> dF = gradient * e.F, dR = rotation_differential(e.R, e.K, dF);
                const Mat3<P> A = stress_differential(e.F, dR, e.k, dF) * e.F.transpose();
                for (int l = 0; l < e.count; ++l) e.scatter(A, l, out);
            }
        });
        return f;
    }

private:
    /// Eight particles of a block, or what is left of them.
    struct Element {
        P N[3][width], dN[3][width];    ///< weights along the axes [1], derivatives [1/m]
        int at[lanes];                  ///< where in the tile the stencils begin.
        int count;
        Mat3<P> F, R, K;                ///< F_E, its rotation, (tr S · I − S)⁻¹
        Lame<P> k;                      ///< V⁰ μ and V⁰ λ, hardened [J]

        /// Σ_j u_j ∇w_jpᵀ of lane l, into the lane of `gradient`.
        void gather(const Tile<NodeVector<Real>, width>& u, int l, Mat3<P>& gradient) const {
            using N4 = NodeVector<Real>;
            N4 dx(0), dy(0), dz(0);
            for (int i = 0; i < width; ++i) {
                N4 value(0), value_dy(0), value_dz(0);
                for (int j = 0; j < width; ++j) {
                    const N4* row = &u.values[at[l] + u.index(i, j, 0)];
                    N4 sum(0), sum_dz(0);
                    for (int m = 0; m < width; ++m) sum += N4(N[2][m][l]) * row[m], sum_dz += N4(dN[2][m][l]) * row[m];
                    value += N4(N[1][j][l]) * sum, value_dy += N4(dN[1][j][l]) * sum, value_dz += N4(N[1][j][l]) * sum_dz;
                }
                dx += N4(dN[0][i][l]) * value, dy += N4(N[0][i][l]) * value_dy, dz += N4(N[0][i][l]) * value_dz;
            }
            for (int c = 0; c < 3; ++c)
                gradient(c, 0).lanes[l] = dx[c], gradient(c, 1).lanes[l] = dy[c], gradient(c, 2).lanes[l] = dz[c];
        }
        /// Adds A ∇w_ip of lane l to the nodes.
        void scatter(const Mat3<P>& A, int l, Tile<NodeVector<Real>, width>& f) const {
            using N4 = NodeVector<Real>;
            const N4 x = N4::of(A(0, 0)[l], A(1, 0)[l], A(2, 0)[l], 0), y = N4::of(A(0, 1)[l], A(1, 1)[l], A(2, 1)[l], 0),
                     z = N4::of(A(0, 2)[l], A(1, 2)[l], A(2, 2)[l], 0);
            for (int i = 0; i < width; ++i) {
                const N4 of_x = N4(dN[0][i][l]) * x, of_y = N4(N[0][i][l]) * y, of_z = N4(N[0][i][l]) * z;
                for (int j = 0; j < width; ++j) {
                    const N4 of_xy = N4(N[1][j][l]) * of_x + N4(dN[1][j][l]) * of_y, of_yz = N4(N[1][j][l]) * of_z;
                    N4* row = &f.values[at[l] + f.index(i, j, 0)];
                    for (int m = 0; m < width; ++m) row[m] += N4(N[2][m][l]) * of_xy + N4(dN[2][m][l]) * of_yz;
                }
            }
        }
    };

    Element element(const Particles<Real>& ps, const ParticleBlock& b, std::uint32_t first,
                    const std::vector<SnowModel<Real>>& materials) const {
        Element e{};
        e.count = static_cast<int>(std::min<std::uint32_t>(lanes, b.end - first));
        e.F = Mat3<P>::Identity();      // harmless where there is no particle
        for (int l = 0; l < e.count; ++l) {
            const std::uint32_t p = first + l;
            const Stencil<Real, kind> s(vector_of(ps.x, p), grid_.h);
            const Vec3i at = s.base - block_width * b.coordinates;
            e.at[l] = Tile<NodeVector<Real>, width>::index(at(0), at(1), at(2));
            for (int a = 0; a < 3; ++a)
                for (int i = 0; i < width; ++i) e.N[a][i].lanes[l] = s.N[a][i], e.dN[a][i].lanes[l] = s.dN[a][i];
            for (int i = 0; i < 9; ++i) e.F(i).lanes[l] = ps.Fe.at(p, i);
            const Lame<Real> k = hardened(materials[ps.material.empty() ? 0 : ps.material[p]], ps.Jp.at(p));
            e.k.mu.lanes[l] = ps.V0.at(p) * k.mu, e.k.lambda.lanes[l] = ps.V0.at(p) * k.lambda;
        }
        const Decomposition<P> d = decompose(e.F);
        e.R = d.rotation();
        e.K = rotation_system_inverse(Mat3<P>(d.V * d.s.asDiagonal() * d.V.transpose()));
        return e;
    }

    const Grid<Real>& grid_;
    std::vector<Element> elements_;
    std::vector<std::size_t> first_;    ///< element of every particle block.
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
