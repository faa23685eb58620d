#pragma once
#include "sim/node_field.h"
#include "sim/transfer.h"

namespace firn {

/// Four nodes that follow each other along z: x y z 0 x y z 0 x y z 0 x y z 0.
template <class Real> struct NodeRow {
    Pack<Real, 8> first, last;              ///< nodes 0 and 1, 2 and 3.
    NodeRow() : first(0), last(0) {}
    explicit NodeRow(const NodeVector<Real>* at) {
        std::memcpy(&first, at, sizeof first), std::memcpy(&last, at + 2, sizeof last);
    }
    NodeRow(Pack<Real, 8> f, Pack<Real, 8> l) : first(f), last(l) {}
    void store(NodeVector<Real>* at) const {
        std::memcpy(at, &first, sizeof first), std::memcpy(at + 2, &last, sizeof last);
    }
    NodeRow& operator+=(const NodeRow& b) { first += b.first, last += b.last; return *this; }
    friend NodeRow operator+(const NodeRow& a, const NodeRow& b) { return {a.first + b.first, a.last + b.last}; }
    friend NodeRow operator*(Pack<Real, 8> a, const NodeRow& b) { return {a * b.first, a * b.last}; }
    friend NodeRow operator*(const NodeRow& a, const NodeRow& b) { return {a.first * b.first, a.last * b.last}; }
};

/// Up to eight particles: all that a solve needs of them and that it does not change.
template <class Real, Weights kind> struct Element {
    using P = Pack<Real, lanes>;
    using N4 = NodeVector<Real>;
    using N8 = Pack<Real, 8>;
    using Row = NodeRow<Real>;
    static constexpr int width = BSpline<kind>::width;

    Vec3<P> t;                      ///< x/h − base [1].
    std::array<int, lanes> at;      ///< where in their blocks' tiles the stencils begin.
    Mat3<P> Fe;                     ///< F_Eⁿ; I in lanes without a particle.
    Lame<P> k;                      ///< V⁰ μ and V⁰ λ, hardened [J]; 0 in lanes without a particle.

    /// Columns (x 0 y 0), (z 0 · ·) of a matrix of each particle.
    struct Columns { std::array<N8, lanes> xy{}, z{}; };

    /// Lane l of ∇u = Σ_j u_j ∇w_jpᵀ: four nodes along z at once, over x and y first. What is beside a row of three stays
    /// in lanes of its own, and is left out in the end.
    void gather(const Tile<N4, width>& u, const Stencils<Real, kind>& s, int l, Columns& gradient) const {
        const N4* corner = &u.values[at[l]];
        Row plain, dx, dy;
#pragma GCC unroll 4
        for (int i = 0; i < width; ++i) {
            Row value, value_dy;
#pragma GCC unroll 4
            for (int j = 0; j < width; ++j) {
                const Row nodes(corner + u.index(i, j, 0));
                value += N8(s.N[1][j][l]) * nodes, value_dy += N8(s.dN[1][j][l]) * nodes;
            }
            plain += N8(s.N[0][i][l]) * value, dx += N8(s.dN[0][i][l]) * value, dy += N8(s.N[0][i][l]) * value_dy;
        }
        const Row N = along_row(s.N[2], l), dN = along_row(s.dN[2], l);
        const N8 x = folded(N * dx), y = folded(N * dy), z = folded(dN * plain);
        // (x₀ | x₁) and (y₀ | y₁) to (x₀ + x₁ | y₀ + y₁)
        gradient.xy[l] = halves(x, y) + exchanged(halves(y, x));
        gradient.z[l] = z + exchanged(z);
    }

    /// f_i += A ∇w_ip for lane l.
    void scatter(const Columns& A, const Stencils<Real, kind>& s, int l, Tile<N4, width>& f) const {
        N4* corner = &f.values[at[l]];
        const Row N = along_row(s.N[2], l);
        const Row x = N * repeated(lower(A.xy[l])), y = N * repeated(lower(exchanged(A.xy[l])));
        const Row z = along_row(s.dN[2], l) * repeated(lower(A.z[l]));
#pragma GCC unroll 4
        for (int i = 0; i < width; ++i) {
            const Row of_xz = N8(s.dN[0][i][l]) * x + N8(s.N[0][i][l]) * z, of_y = N8(s.N[0][i][l]) * y;
#pragma GCC unroll 4
            for (int j = 0; j < width; ++j) {
                N4* row = corner + f.index(i, j, 0);
                (N8(s.dN[1][j][l]) * of_y + (N8(s.N[1][j][l]) * of_xz + Row(row))).store(row);
            }
        }
    }

    /// sum_i += (λ + 4μ)/3 V_p⁰ ‖∇w_ip‖² for lane l, four nodes along z at once; a fourth one of three gets nothing.
    void scatter_diagonal(const Stencils<Real, kind>& s, int l, Tile<Real, width>& sum) const {
        const Real stiffness = (k.lambda[l] + 4 * k.mu[l]) / 3;
        Real* corner = &sum.values[at[l]];
        N4 N2(0), dN2(0);
        for (int m = 0; m < width; ++m) N2.lanes[m] = s.N[2][m][l] * s.N[2][m][l], dN2.lanes[m] = s.dN[2][m][l] * s.dN[2][m][l];
        for (int i = 0; i < width; ++i)
            for (int j = 0; j < width; ++j) {
                const Real NN = s.N[0][i][l] * s.N[1][j][l], dNN = s.dN[0][i][l] * s.N[1][j][l], NdN = s.N[0][i][l] * s.dN[1][j][l];
                Real* row = corner + sum.index(i, j, 0);
                N4 nodes;
                std::memcpy(&nodes, row, sizeof nodes);
                nodes += N4(stiffness * (dNN * dNN + NdN * NdN)) * N2 + N4(stiffness * NN * NN) * dN2;
                std::memcpy(row, &nodes, sizeof nodes);
            }
    }

private:
    /// A weight of lane l for each node of a row; beside a row of three the last one is 0.
    static Row along_row(const P (&w)[width], int l) {
        const Real last = width == 4 ? w[width - 1][l] : Real(0);
        const N4 each = N4::of(w[0][l], w[1][l], w[2][l], last);
        return {N8::of(__builtin_shufflevector(each.lanes, each.lanes, 0, 0, 0, 0, 1, 1, 1, 1)),
                N8::of(__builtin_shufflevector(each.lanes, each.lanes, 2, 2, 2, 2, 3, 3, 3, 3))};
    }
    static Row repeated(N4 a) {
        const N8 both = N8::of(__builtin_shufflevector(a.lanes, a.lanes, 0, 1, 2, 3, 0, 1, 2, 3));
        return {both, both};
    }
    /// Nodes 0 and 2, nodes 1 and 3 of a row, those that there are.
    static N8 folded(Row a) {
        return a.first + (width == 4 ? a.last : halves(a.last, N8(0)));
    }
    static N4 lower(N8 a) { return N4::of(__builtin_shufflevector(a.lanes, a.lanes, 0, 1, 2, 3)); }
};

/// All particles awake as elements, colour after colour, so that nodes are summed in a fixed order and by one thread at
/// a time. What comes apart leaves a particle or two in a block; eight of them are worked on at once all the same.
template <class Real, Weights kind> class Elements {
public:
    using P = Pack<Real, lanes>;
    using N4 = NodeVector<Real>;
    static constexpr int width = BSpline<kind>::width;

    Elements(const Particles<Real>& ps, const Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials)
        : blocks_(grid.blocks), h_(grid.h) {
        std::size_t elements = 0;
        for (std::size_t c = 0; c < blocks_.colours.size(); ++c) {
            const std::vector<std::uint32_t>& colour = blocks_.colours[c];
            for (std::size_t b = 0; b < colour.size();) {
                Batch batch{elements, 0, {}};
                do {
                    if (blocks_.particle_blocks[colour[b]].asleep()) continue;
                    batch.blocks.push_back(&blocks_.particle_blocks[colour[b]]);
                    batch.particles += batch.blocks.back()->count;
                } while (++b < colour.size() && batch.particles + blocks_.particle_blocks[colour[b]].count <= enough);
                elements += batch.elements();
                if (!batch.blocks.empty()) batches_[c].push_back(std::move(batch));
            }
        }
        elements_.resize(elements);     // zeroed
        for_each_batch([&](const Batch& batch) {
            if (batch.blocks.size() == 1) {
                const ParticleBlock& b = *batch.blocks[0];
                for (std::size_t n = 0; n < b.groups.size(); ++n) fill(elements_[batch.first + n], ps, grid.h, b, b.groups[n], materials);
                return;
            }
            for (std::size_t n = 0; n < batch.elements(); ++n) elements_[batch.first + n].Fe = Mat3<P>::Identity();
            batch.for_each([&](const ParticleBlock& b, std::size_t q) {
                for (std::uint32_t n = 0; n < b.count; ++n, ++q)
                    fill(elements_[batch.first + q / lanes], q % lanes, ps, grid.h, b, b.slot(n), materials);
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
        out.at.resize(blocks_.nodes);
        out.for_each([&](std::ptrdiff_t i) { out.at[i] = N4(0); });
        for_each_batch([&](const Batch& batch) {
            thread_local std::vector<typename Element<Real, kind>::Columns> columns;
            columns.assign(batch.elements(), {});
            Tile<N4, width> tile;
            for_each_particle(batch, [&](const ParticleBlock& b) { tile.load(blocks_, b, u.at); },
                              [&](const auto& e, const auto& s, std::size_t n, int l) { e.gather(tile, s, l, columns[n]); }, [](auto&) {});
            for (std::size_t n = 0; n < columns.size(); ++n) apply(columns[n], batch.first + n, f);
            for_each_particle(batch, [&](const ParticleBlock& b) { tile.clear(blocks_, b); },
                              [&](const auto& e, const auto& s, std::size_t n, int l) { e.scatter(columns[n], s, l, tile); },
                              [&](const ParticleBlock& b) { tile.add_to(blocks_, b, out.at); });
        });
    }

    /// Σ_p (λ + 4μ)/3 V_p⁰ ‖∇w_ip‖²: a third of the trace of each node's own 3×3 block of ∂²Φ/∂x² for F_E = I.
    Pages<Real> diagonal() const {
        Pages<Real> sum(blocks_.nodes);
        for_each_batch([&](const Batch& batch) {
            Tile<Real, width> tile;
            std::memset(&tile, 0, sizeof tile);     // with what is read and written beside a row's end
            for_each_particle(batch, [&](const ParticleBlock& b) { tile.clear(blocks_, b); },
                              [&](const auto& e, const auto& s, std::size_t, int l) { e.scatter_diagonal(s, l, tile); },
                              [&](const ParticleBlock& b) { tile.add_to(blocks_, b, sum); });
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
            for (const ParticleBlock* b : blocks) f(*b, q), q += b->count;
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

    /// Calls before(block), f(element, its weights, its number in the batch, lane) for the block's particles, and
    /// after(block), for all blocks of a batch.
    template <class Before, class F, class After>
    void for_each_particle(const Batch& batch, Before&& before, F&& f, After&& after) const {
        Stencils<Real, kind> s;
        std::size_t known = batch.elements();
        batch.for_each([&](const ParticleBlock& b, std::size_t q) {
            before(b);
            for (const std::size_t end = q + b.count; q < end; ++q) {
                const std::size_t n = q / lanes;
                const Element<Real, kind>& e = elements_[batch.first + n];
                if (n != known) s = Stencils<Real, kind>(e.t, h_), known = n;
                f(e, s, n, int(q % lanes));
            }
            after(b);
        });
    }
    /// ∇u of eight particles → f(n, element n, ∇u)
    template <class F> void apply(typename Element<Real, kind>::Columns& c, std::size_t n, F&& f) const {
        transpose(c.xy), transpose(c.z);
        Mat3<P> G;
        for (int i = 0; i < 3; ++i) G(i, 0) = c.xy[i], G(i, 1) = c.xy[4 + i], G(i, 2) = c.z[i];
        const Mat3<P> A = f(n, elements_[n], G);
        c.xy = {A(0, 0), A(1, 0), A(2, 0), P(0), A(0, 1), A(1, 1), A(2, 1), P(0)};
        c.z = {A(0, 2), A(1, 2), A(2, 2), P(0), A(0, 2), A(1, 2), A(2, 2), P(0)};
        transpose(c.xy), transpose(c.z);
    }

    /// All lanes from one group.
    static void fill(Element<Real, kind>& e, const Particles<Real>& ps, Real h, const ParticleBlock& b, std::uint32_t group,
                     const std::vector<SnowModel<Real>>& materials) {
        const Place<kind, P> place(vectors_of(ps.x, group), P(h));
        e.at = tile_corners<Real, kind>(place, b);
        e.t = place.t;
        e.Fe = matrices_of(ps.Fe, group);
        const Lame<P> k = hardened(models_of(ps, materials, group), ps.Jp.pack(group));
        e.k = {ps.V0.pack(group) * k.mu, ps.V0.pack(group) * k.lambda};
    }
    /// One lane.
    static void fill(Element<Real, kind>& e, int l, const Particles<Real>& ps, Real h, const ParticleBlock& b,
                     std::size_t slot, const std::vector<SnowModel<Real>>& materials) {
        const Place<kind, Real> place(vector_of(ps.x, slot), h);
        const Vec3i at = place.base.template cast<int>() - block_width * b.coordinates;
        e.at[l] = Tile<N4, width>::index(at(0), at(1), at(2));
        for (int a = 0; a < 3; ++a) e.t(a).lanes[l] = place.t(a);
        for (int i = 0; i < 9; ++i) e.Fe(i).lanes[l] = ps.Fe.at(slot, i);
        const Lame<Real> k = hardened(materials[ps.material_of(slot)], ps.Jp.at(slot));
        e.k.mu.lanes[l] = ps.V0.at(slot) * k.mu, e.k.lambda.lanes[l] = ps.V0.at(slot) * k.lambda;
    }

    const Blocks& blocks_;
    Real h_;
    Pages<Element<Real, kind>> elements_;
    std::array<std::vector<Batch>, 8> batches_;  ///< by colour.
};

}  // namespace firn
