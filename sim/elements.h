#pragma once
#include "sim/node_field.h"
#include "sim/transfer.h"

namespace firn {

/// Up to eight particles: all that a solve needs of them and that it does not change.
template <class Real, Weights kind> struct Element {
    using P = Pack<Real, lanes>;
    using N4 = NodeVector<Real>;
    static constexpr int width = BSpline<kind>::width;

    P N[3][width], dN[3][width];    ///< weights along the axes [1], derivatives [1/m].
    int at[lanes];                  ///< where in their blocks' tiles the stencils begin.
    Mat3<P> Fe;                     ///< F_Eⁿ; I in lanes without a particle.
    Lame<P> k;                      ///< V⁰ μ and V⁰ λ, hardened [J]; 0 in lanes without a particle.

    /// Lane l of ∇u = Σ_j u_j ∇w_jpᵀ
    void gather(const Tile<N4, width>& u, int l, Mat3<P>& gradient) const {
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

    /// f_i += A_p ∇w_ip for lane l.
    void scatter(const Mat3<P>& A, int l, Tile<N4, width>& f) const {
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

    /// sum_i += (λ + 4μ)/3 V_p⁰ ‖∇w_ip‖² for lane l.
    void scatter_diagonal(int l, Tile<N4, width>& sum) const {
        const Real stiffness = (k.lambda[l] + 4 * k.mu[l]) / 3;
        for (int i = 0; i < width; ++i)
            for (int j = 0; j < width; ++j) {
                const Real NN = N[0][i][l] * N[1][j][l], dNN = dN[0][i][l] * N[1][j][l], NdN = N[0][i][l] * dN[1][j][l];
                const Real across = stiffness * (dNN * dNN + NdN * NdN), along = stiffness * NN * NN;
                for (int m = 0; m < width; ++m)
                    sum.values[at[l] + sum.index(i, j, m)] +=
                        N4(across * N[2][m][l] * N[2][m][l] + along * dN[2][m][l] * dN[2][m][l]);
            }
    }
};

/// All particles as elements, colour after colour, so that nodes are summed in a fixed order and by one thread at
/// a time. What comes apart leaves a particle or two in a block; eight of them are worked on at once all the same.
template <class Real, Weights kind> class Elements {
public:
    using P = Pack<Real, lanes>;
    using N4 = NodeVector<Real>;
    static constexpr int width = BSpline<kind>::width;

    Elements(const Particles<Real>& ps, const Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials)
        : blocks_(grid.blocks) {
        std::size_t elements = 0;
        for (std::size_t c = 0; c < blocks_.colours.size(); ++c) {
            const std::vector<std::uint32_t>& colour = blocks_.colours[c];
            for (std::size_t b = 0; b < colour.size();) {
                Batch batch{elements, 0, {}};
                do {
                    batch.blocks.push_back(&blocks_.particle_blocks[colour[b]]);
                    batch.particles += batch.blocks.back()->size();
                } while (++b < colour.size() && batch.particles + blocks_.particle_blocks[colour[b]].size() <= enough);
                elements += batch.elements();
                batches_[c].push_back(std::move(batch));
            }
        }
        elements_.resize(elements);
        for (Element<Real, kind>& e : elements_) e.Fe = Mat3<P>::Identity();
        for_each_batch([&](const Batch& batch) {
            batch.for_each([&](const ParticleBlock& b, std::size_t q) {
                for (std::uint32_t p = b.begin; p < b.end; ++p, ++q)
                    fill(elements_[batch.first + q / lanes], q % lanes, ps, grid.h, b, p, materials);
            });
        });
    }

    std::size_t size() const { return elements_.size(); }

    /// Calls f(n, element) for every element n, several at once.
    template <class F> void for_each(F&& f) const {
        const auto count = static_cast<std::ptrdiff_t>(size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t n = 0; n < count; ++n) f(n, elements_[n]);
    }

    /// out_i = Σ_p A_p ∇w_ip with A_p = f(n, element n, ∇u_p), eight particles at a time.
    template <class F> void map_gradients(const NodeField<Real>& u, NodeField<Real>& out, F&& f) const {
        out.at.assign(blocks_.nodes, N4(0));
        for_each_batch([&](const Batch& batch) {
            thread_local std::vector<Mat3<P>> A;
            A.assign(batch.elements(), Mat3<P>::Zero());
            Tile<N4, width> tile;
            batch.for_each([&](const ParticleBlock& b, std::size_t q) {
                tile.load(blocks_, b, u.at);
                for (const std::size_t end = q + b.size(); q < end; ++q)
                    elements_[batch.first + q / lanes].gather(tile, q % lanes, A[q / lanes]);
            });
            for (std::size_t n = 0; n < A.size(); ++n) A[n] = f(batch.first + n, elements_[batch.first + n], A[n]);
            batch.for_each([&](const ParticleBlock& b, std::size_t q) {
                tile.clear(blocks_, b);
                for (const std::size_t end = q + b.size(); q < end; ++q)
                    elements_[batch.first + q / lanes].scatter(A[q / lanes], q % lanes, tile);
                tile.add_to(blocks_, b, out.at);
            });
        });
    }

    /// Σ_p (λ + 4μ)/3 V_p⁰ ‖∇w_ip‖²: a third of the trace of each node's own 3×3 block of ∂²Φ/∂x² for F_E = I.
    NodeField<Real> diagonal() const {
        NodeField<Real> sum(blocks_.nodes);
        for_each_batch([&](const Batch& batch) {
            Tile<N4, width> tile;
            batch.for_each([&](const ParticleBlock& b, std::size_t q) {
                tile.clear(blocks_, b);
                for (const std::size_t end = q + b.size(); q < end; ++q)
                    elements_[batch.first + q / lanes].scatter_diagonal(q % lanes, tile);
                tile.add_to(blocks_, b, sum.at);
            });
        });
        return sum;
    }

private:
    /// Blocks of one colour whose particles share elements: as many as it takes to fill some.
    struct Batch {
        std::size_t first, particles;       ///< element; how many from it on.
        std::vector<const ParticleBlock*> blocks;
        std::size_t elements() const { return (particles + lanes - 1) / lanes; }

        /// Calls f(block, q) for every block, the first of whose particles is lane q % 8 of element first + q / 8.
        template <class F> void for_each(F&& f) const {
            std::size_t q = 0;
            for (const ParticleBlock* b : blocks) f(*b, q), q += b->size();
        }
    };
    static constexpr std::size_t enough = 64;   ///< particles in a batch of more than one block.

    /// Calls f(batch) for every batch, several of one colour at once.
    template <class F> void for_each_batch(F&& f) const {
#pragma omp parallel
        for (const std::vector<Batch>& colour : batches_) {
            const auto count = static_cast<std::ptrdiff_t>(colour.size());
#pragma omp for schedule(dynamic)
            for (std::ptrdiff_t n = 0; n < count; ++n) f(colour[n]);
        }
    }

    static void fill(Element<Real, kind>& e, int l, const Particles<Real>& ps, Real h, const ParticleBlock& b,
                     std::uint32_t p, const std::vector<SnowModel<Real>>& materials) {
        const Stencil<Real, kind> s(vector_of(ps.x, p), h);
        const Vec3i at = s.base - block_width * b.coordinates;
        e.at[l] = Tile<N4, width>::index(at(0), at(1), at(2));
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < width; ++i) e.N[a][i].lanes[l] = s.N[a][i], e.dN[a][i].lanes[l] = s.dN[a][i];
        for (int i = 0; i < 9; ++i) e.Fe(i).lanes[l] = ps.Fe.at(p, i);
        const Lame<Real> k = hardened(materials[ps.material.empty() ? 0 : ps.material[p]], ps.Jp.at(p));
        e.k.mu.lanes[l] = ps.V0.at(p) * k.mu, e.k.lambda.lanes[l] = ps.V0.at(p) * k.lambda;
    }

    const Blocks& blocks_;
    std::vector<Element<Real, kind>> elements_;
    std::array<std::vector<Batch>, 8> batches_;  ///< by colour.
};

}  // namespace firn
