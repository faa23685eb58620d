#pragma once
#include "sim/node_field.h"
#include "sim/stiffness.h"
#include "sim/transfer.h"

#include <bit>

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
    Lame<P> k;                      ///< w V⁰ μ and w V⁰ λ, hardened [J]; 0 in lanes without a particle.
    std::array<std::uint32_t, lanes> slot;  ///< of the particles; `no_slot`.

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

constexpr std::uint32_t no_slot = 0xffffffff;   ///< of a lane without a particle.

/// The particles awake that a solve makes implicit, as elements, and the nodes that they reach, numbered anew. Blocks go
/// colour after colour, so that nodes are summed in a fixed order and by one thread at a time.
template <class Real, Weights kind> class Elements {
public:
    using P = Pack<Real, lanes>;
    using N4 = NodeVector<Real>;
    static constexpr int width = BSpline<kind>::width;

    /// A block's implicit particles.
    struct StiffBlock {
        std::uint32_t first, count;             ///< element; particles from it on.
        std::vector<Link> links;                ///< their nodes in the block's tile, by their new numbers.
        std::vector<NodeSet> parts;             ///< base nodes whose stencils hang together.
    };

    Elements(const Particles<Real>& ps, const Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials,
             const StiffnessLimits& limits)
        : h_(grid.h) {
        const std::vector<ParticleBlock>& all = grid.blocks.particle_blocks;
        std::vector<StiffBlock> found(all.size());
        Pages<Lame<P>> k(ps.groups);
        const auto count = static_cast<std::ptrdiff_t>(all.size());
#pragma omp parallel for schedule(dynamic, 4)
        for (std::ptrdiff_t b = 0; b < count; ++b)
            if (!all[b].asleep()) found[b] = look_through(ps, grid, materials, limits, all[b], k);
        number(grid, found);
        elements_.resize(place(grid, found));
#pragma omp parallel for schedule(dynamic, 4)
        for (std::ptrdiff_t b = 0; b < count; ++b) {
            if (found[b].count > 0) fill(ps, all[b], found[b], k);
            for (Link& l : found[b].links) l.node = number_[l.node];
        }
        blocks_ = std::move(found);
    }

    std::size_t size() const { return elements_.size(); }
    std::size_t nodes() const { return nodes_.size(); }
    /// The nodes' places in the grid's flat array, in ascending order.
    const std::vector<std::uint32_t>& grid_nodes() const { return nodes_; }
    /// The new number of a node of the grid; `no_slot` where no implicit particle reaches it.
    std::uint32_t number_of(std::size_t grid_node) const { return number_[grid_node]; }
    /// Of all blocks, most of them empty where little is stiff.
    const std::vector<StiffBlock>& blocks() const { return blocks_; }

    /// Calls f(n, element) for every element n, several at once.
    template <class F> void for_each(F&& f) const {
        const auto count = static_cast<std::ptrdiff_t>(size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t n = 0; n < count; ++n) f(n, elements_[n]);
    }

    /// out_i = Σ_p A_p ∇w_ip with A_p = f(n, element n, ∇u_p), eight particles at a time.
    template <class F> void map_gradients(const NodeField<Real>& u, NodeField<Real>& out, F&& f) const {
        out.at.resize(nodes());
        out.for_each([&](std::ptrdiff_t i) { out.at[i] = N4(0); });
        for_each_block([&](const StiffBlock& b) {
            thread_local std::vector<typename Element<Real, kind>::Columns> columns;
            columns.assign((b.count + lanes - 1) / lanes, {});
            Tile<N4, width> tile;
            for (const Link& l : b.links) tile.values[l.at] = u.at[l.node];
            for_each_particle(b, [&](const auto& e, const auto& s, std::size_t n, int l) { e.gather(tile, s, l, columns[n]); });
            for (std::size_t n = 0; n < columns.size(); ++n) apply(columns[n], b.first + n, f);
            for (const Link& l : b.links) tile.values[l.at] = N4(0);
            for_each_particle(b, [&](const auto& e, const auto& s, std::size_t n, int l) { e.scatter(columns[n], s, l, tile); });
            for (const Link& l : b.links) out.at[l.node] += tile.values[l.at];
        });
    }

    /// Σ_p (λ + 4μ)/3 V_p⁰ ‖∇w_ip‖²: a third of the trace of each node's own 3×3 block of ∂²Φ/∂x² for F_E = I.
    Pages<Real> diagonal() const {
        Pages<Real> sum(nodes());
        for_each_block([&](const StiffBlock& b) {
            Tile<Real, width> tile;
            std::memset(&tile, 0, sizeof tile);     // with what is read and written beside a row's end
            for_each_particle(b, [&](const auto& e, const auto& s, std::size_t, int l) { e.scatter_diagonal(s, l, tile); });
            for (const Link& l : b.links) sum[l.node] += tile.values[l.at];
        });
        return sum;
    }

    static constexpr int tile_width = Tile<N4, width>::width;
    /// The nodes of a tile that stencils reach from these base nodes: for each row along z a bit a node.
    using Rows = std::array<std::uint16_t, tile_width * tile_width>;
    static Rows reached(NodeSet bases) {
        Rows rows{};
        for (NodeSet left = bases; left != 0; left &= left - 1) {
            const int bit = std::countr_zero(left), i = bit >> 4, j = (bit >> 2) & 3, k = bit & 3;
            for (int a = 0; a < width; ++a)
                for (int c = 0; c < width; ++c) rows[(i + a) * tile_width + j + c] |= std::uint16_t(((1 << width) - 1) << k);
        }
        return rows;
    }
    static bool is_in(const Rows& rows, std::uint32_t at) { return rows[at / tile_width] >> (at % tile_width) & 1; }

private:
    /// Base nodes whose stencils share nodes with those of `from`: within `width` − 1 of them along each axis.
    static NodeSet neighbours(NodeSet from) {
        constexpr NodeSet low_z = 0x1111111111111111, low_y = 0x000f000f000f000f;
        for (int n = 1; n < width; ++n) {
            from |= (from & ~(low_z << 3)) << 1 | (from & ~low_z) >> 1;
            from |= (from & ~(low_y << 12)) << 4 | (from & ~low_y) >> 4;
            from |= from << 16 | from >> 16;
        }
        return from;
    }

    /// Counts the block's implicit particles, gives k their weighted stiffness, and finds the nodes that they reach.
    static StiffBlock look_through(const Particles<Real>& ps, const Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials,
                                   const StiffnessLimits& limits, const ParticleBlock& b, Pages<Lame<P>>& k) {
        StiffBlock found{};
        NodeSet bases = 0;
        for (std::size_t n = 0; n < b.groups.size(); ++n) {
            const std::uint32_t g = b.groups[n];
            const Lame<P> lame = hardened(models_of(ps, materials, g), ps.Jp.pack(g));
            const P V0 = ps.V0.pack(g), m = ps.m.pack(g);
            const P x2 = select(m > P(0), P((lame.lambda + P(2) * lame.mu) * V0 / m * P(Real(limits.scale2))), P(0));
            P limit2 = P(Real(limits.limit2[0]));
            for (int l = 0; ps.several_materials && l < lanes; ++l) limit2.lanes[l] = Real(limits.limit2[ps.material[g * lanes + l]]);
            const P w = implicit_weight(x2, limit2) * V0;
            k[g] = {w * lame.mu, w * lame.lambda};
            if (!any(w > P(0))) continue;
            const Vec3<P> base = Place<kind, P>(vectors_of(ps.x, g), P(grid.h)).base;
            Vec3<P> local;
            for (int a = 0; a < 3; ++a) local(a) = base(a) - P(Real(block_width * b.coordinates(a)));
            const auto bits = integers(select(w > P(0), P((local(0) * P(16) + local(1) * P(4)) + local(2)), P(0)));
            for (int l = 0; l < b.count_in(n); ++l)
                if (w[l] > 0) bases |= NodeSet(1) << bits[l], ++found.count;
        }
        if (found.count == 0) return found;
        const Rows rows = reached(bases);
        for (std::uint32_t l = b.first_link; l < b.last_link; ++l)
            if (is_in(rows, grid.blocks.links[l].at)) found.links.push_back(grid.blocks.links[l]);
        for (NodeSet left = bases; left != 0;) {
            NodeSet part = left & -left;
            for (NodeSet before = 0; before != part;) before = part, part = neighbours(part) & left;
            found.parts.push_back(part), left &= ~part;
        }
        return found;
    }

    /// Numbers the nodes that are reached, in the order of the grid's.
    void number(const Grid<Real>& grid, const std::vector<StiffBlock>& found) {
        number_.assign(grid.size(), no_slot);
        for (const StiffBlock& b : found)
            for (const Link& l : b.links) number_[l.node] = 0;
        for (std::size_t i = 0; i < number_.size(); ++i)
            if (number_[i] == 0) number_[i] = static_cast<std::uint32_t>(nodes_.size()), nodes_.push_back(static_cast<std::uint32_t>(i));
    }

    /// Gives every block its elements; returns how many there are.
    std::size_t place(const Grid<Real>& grid, std::vector<StiffBlock>& found) {
        std::uint32_t elements = 0;
        for (StiffBlock& b : found) b.first = elements, elements += (b.count + lanes - 1) / lanes;
        for (std::size_t c = 0; c < colours_.size(); ++c)
            for (const std::uint32_t b : grid.blocks.colours[c])
                if (found[b].count > 0) colours_[c].push_back(b);
        return elements;
    }

    /// A block's elements from its particles.
    void fill(const Particles<Real>& ps, const ParticleBlock& b, const StiffBlock& to, const Pages<Lame<P>>& k) {
        std::size_t q = 0;
        for (std::size_t n = 0; n < b.groups.size(); ++n) {
            const std::uint32_t g = b.groups[n];
            if (!any(k[g].mu > P(0))) continue;
            const Place<kind, P> place(vectors_of(ps.x, g), P(Real(h_)));
            const std::array<int, lanes> at = tile_corners<Real, kind>(place, b);
            for (int l = 0; l < b.count_in(n); ++l) {
                if (!(k[g].mu[l] > 0)) continue;
                Element<Real, kind>& e = elements_[to.first + q / lanes];
                const int to_lane = static_cast<int>(q++ % lanes);
                for (int a = 0; a < 3; ++a) e.t(a).lanes[to_lane] = place.t(a)[l];
                e.at[to_lane] = at[l], e.slot[to_lane] = std::uint32_t(lanes) * g + l;
                e.k.mu.lanes[to_lane] = k[g].mu[l], e.k.lambda.lanes[to_lane] = k[g].lambda[l];
            }
        }
        for (; q % lanes != 0; ++q) elements_[to.first + q / lanes].slot[q % lanes] = no_slot;
    }

    /// Calls f(block) for every block that holds something, several of one colour at once.
    template <class F> void for_each_block(F&& f) const {
#pragma omp parallel
        for (const std::vector<std::uint32_t>& colour : colours_) {
            const auto count = static_cast<std::ptrdiff_t>(colour.size());
#pragma omp for schedule(dynamic)
            for (std::ptrdiff_t n = 0; n < count; ++n) f(blocks_[colour[n]]);
        }
    }

    /// Calls f(element, its weights, its number in the block, lane) for the block's particles.
    template <class F> void for_each_particle(const StiffBlock& b, F&& f) const {
        for (std::uint32_t q = 0; q < b.count; q += lanes) {
            const Element<Real, kind>& e = elements_[b.first + q / lanes];
            const Stencils<Real, kind> s(e.t, h_);
            for (int l = 0; l < std::min<int>(lanes, b.count - q); ++l) f(e, s, q / lanes, l);
        }
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

    Real h_;
    Pages<Element<Real, kind>> elements_;
    std::vector<StiffBlock> blocks_;
    std::array<std::vector<std::uint32_t>, 8> colours_;     ///< of the blocks that hold something.
    std::vector<std::uint32_t> nodes_;                      ///< of the grid, by their new numbers.
    std::vector<std::uint32_t> number_;                     ///< new numbers, by those of the grid.
};

/// F_E of an element's particles; I in lanes without one.
template <class Real, Weights kind>
Mat3<Pack<Real, lanes>> strains_of(const Particles<Real>& ps, const Element<Real, kind>& e) {
    Mat3<Pack<Real, lanes>> F = Mat3<Pack<Real, lanes>>::Identity();
    for (int l = 0; l < lanes; ++l)
        for (int i = 0; i < 9 && e.slot[l] != no_slot; ++i) F(i).lanes[l] = ps.Fe.at(e.slot[l], i);
    return F;
}

}  // namespace firn
