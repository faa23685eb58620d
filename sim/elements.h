#pragma once
#include "sim/node_field.h"
#include "sim/transfer.h"

namespace firn {

/// Eight particles of a block, or what is left of them: all that a solve needs of them and that it does not change.
template <class Real, Weights kind> struct Element {
    using P = Pack<Real, lanes>;
    using N4 = NodeVector<Real>;
    static constexpr int width = BSpline<kind>::width;

    P N[3][width], dN[3][width];    ///< weights along the axes [1], derivatives [1/m].
    int at[lanes];                  ///< where in the tile the stencils begin.
    int count;
    Mat3<P> Fe;                     ///< F_Eⁿ
    Lame<P> k;                      ///< V⁰ μ and V⁰ λ, hardened [J]; 0 in lanes without a particle.

    /// ∇u = Σ_j u_j ∇w_jpᵀ
    Mat3<P> gradient(const Tile<N4, width>& u) const {
        Mat3<P> result = Mat3<P>::Zero();
        for (int l = 0; l < count; ++l) {
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
                result(c, 0).lanes[l] = dx[c], result(c, 1).lanes[l] = dy[c], result(c, 2).lanes[l] = dz[c];
        }
        return result;
    }

    /// f_i += A_p ∇w_ip
    void scatter(const Mat3<P>& A, Tile<N4, width>& f) const {
        for (int l = 0; l < count; ++l) {
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
    }
};

/// All particles as elements, in the order in which a solve runs through them: block after block.
template <class Real, Weights kind> class Elements {
public:
    using P = Pack<Real, lanes>;
    static constexpr int width = BSpline<kind>::width;

    Elements(const Particles<Real>& ps, const Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials)
        : blocks_(grid.blocks) {
        const std::vector<ParticleBlock>& blocks = blocks_.particle_blocks;
        for (const ParticleBlock& b : blocks) {
            first_.push_back(elements_.size());
            elements_.resize(elements_.size() + (b.end - b.begin + lanes - 1) / lanes);
        }
        const auto count = static_cast<std::ptrdiff_t>(blocks.size());
#pragma omp parallel for schedule(dynamic)
        for (std::ptrdiff_t i = 0; i < count; ++i)
            for (std::uint32_t p = blocks[i].begin; p < blocks[i].end; p += lanes)
                elements_[first_[i] + (p - blocks[i].begin) / lanes] = element(ps, grid.h, blocks[i], p, materials);
    }

    std::size_t size() const { return elements_.size(); }
    std::size_t nodes() const { return blocks_.nodes; }

    /// Calls f(n, element) for every element n, several at once.
    template <class F> void for_each(F&& f) const {
        const auto count = static_cast<std::ptrdiff_t>(size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t n = 0; n < count; ++n) f(n, elements_[n]);
    }

    /// out_i = Σ_p A_p ∇w_ip with A_p = f(n, element n, ∇u_p), eight particles at a time.
    template <class F> void map_gradients(const NodeField<Real>& u, NodeField<Real>& out, F&& f) const {
        using N4 = NodeVector<Real>;
        out.at.assign(blocks_.nodes, N4(0));
        scatter_blocks<width>(blocks_, out.at, [&](const ParticleBlock& b, Tile<N4, width>& sum) {
            Tile<N4, width> in;
            in.load(blocks_, b, u.at);
            const std::size_t first = first_[&b - blocks_.particle_blocks.data()];
            for (std::size_t n = first; n < first + (b.end - b.begin + lanes - 1) / lanes; ++n)
                elements_[n].scatter(f(n, elements_[n], elements_[n].gradient(in)), sum);
        });
    }

    /// Σ_p (λ + 4μ)/3 V_p⁰ ‖∇w_ip‖²: a third of the trace of each node's own 3×3 block of ∂²Φ/∂x² for F_E = I.
    NodeField<Real> diagonal() const {
        using N4 = NodeVector<Real>;
        NodeField<Real> sum(blocks_.nodes);
        scatter_blocks<width>(blocks_, sum.at, [&](const ParticleBlock& b, Tile<N4, width>& tile) {
            const std::size_t first = first_[&b - blocks_.particle_blocks.data()];
            for (std::size_t n = first; n < first + (b.end - b.begin + lanes - 1) / lanes; ++n) {
                const Element<Real, kind>& e = elements_[n];
                const P stiffness = (e.k.lambda + P(4) * e.k.mu) / P(3);
                for (int l = 0; l < e.count; ++l)
                    for (int i = 0; i < width; ++i)
                        for (int j = 0; j < width; ++j) {
                            const Real NN = e.N[0][i][l] * e.N[1][j][l], dNN = e.dN[0][i][l] * e.N[1][j][l],
                                       NdN = e.N[0][i][l] * e.dN[1][j][l];
                            const Real across = stiffness[l] * (dNN * dNN + NdN * NdN), along = stiffness[l] * NN * NN;
                            for (int m = 0; m < width; ++m)
                                tile.values[e.at[l] + tile.index(i, j, m)] += N4(
                                    across * e.N[2][m][l] * e.N[2][m][l] + along * e.dN[2][m][l] * e.dN[2][m][l]);
                        }
            }
        });
        return sum;
    }

private:
    static Element<Real, kind> element(const Particles<Real>& ps, Real h, const ParticleBlock& b, std::uint32_t first,
                                       const std::vector<SnowModel<Real>>& materials) {
        Element<Real, kind> e{};
        e.count = static_cast<int>(std::min<std::uint32_t>(lanes, b.end - first));
        e.Fe = Mat3<P>::Identity();
        for (int l = 0; l < e.count; ++l) {
            const std::uint32_t p = first + l;
            const Stencil<Real, kind> s(vector_of(ps.x, p), h);
            const Vec3i at = s.base - block_width * b.coordinates;
            e.at[l] = Tile<NodeVector<Real>, width>::index(at(0), at(1), at(2));
            for (int a = 0; a < 3; ++a)
                for (int i = 0; i < width; ++i) e.N[a][i].lanes[l] = s.N[a][i], e.dN[a][i].lanes[l] = s.dN[a][i];
            for (int i = 0; i < 9; ++i) e.Fe(i).lanes[l] = ps.Fe.at(p, i);
            const Lame<Real> k = hardened(materials[ps.material.empty() ? 0 : ps.material[p]], ps.Jp.at(p));
            e.k.mu.lanes[l] = ps.V0.at(p) * k.mu, e.k.lambda.lanes[l] = ps.V0.at(p) * k.lambda;
        }
        return e;
    }

    const Blocks& blocks_;
    std::vector<Element<Real, kind>> elements_;
    std::vector<std::size_t> first_;    ///< element of every particle block.
};

}  // namespace firn
