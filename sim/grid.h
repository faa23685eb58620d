#pragma once
#include "sim/blocks.h"
#include "sim/pack.h"
#include "sim/pages.h"

namespace firn {

/// A node. After rasterize:  (m v, m | f, 0).  After the forces:  (v*, m | vⁿ, 0).  For the particles' way back:
/// (vⁿ⁺¹, m | vⁿ⁺¹ − α vⁿ, α) with the share α of FLIP, 0 under APIC.
template <class Real> using Node = Pack<Real, 8>;

/// The nodes under the particles: a flat array, block after block; in a block z runs fastest.
template <class Real> struct Grid {
    Real h = 0;                             ///< [m]
    Blocks blocks;
    Pages<Node<Real>> nodes;

    std::size_t size() const { return blocks.nodes; }
    /// World position of the node (i, j, k) of a block that bit 16 i + 4 j + k stands for [m].
    Vec3d position(const GridBlock& block, int bit) const {
        const Vec3i local(bit >> 4, (bit >> 2) & 3, bit & 3);
        return double(h) * (block_width * block.coordinates.cast<double>() + local.cast<double>());
    }
};

/// The nodes that one block's particles reach, side by side, so that a stencil is a plain triple loop. What no
/// link leads to is not set, and no stencil of the block reads it.
template <class Value, int stencil_width> struct Tile {
    static constexpr int width = block_width + stencil_width - 1;
    Value values[width * width * width + 1];    ///< one more, for four numbers at a time of rows of three.

    /// Of node (i, j, k) of the tile; T: int, or a number that holds integers.
    template <class T> static constexpr T index(T i, T j, T k) { return (i * T(width) + j) * T(width) + k; }

    /// Calls f(value of the tile, index in the flat array) for all nodes that the block's particles reach.
    template <class F> void for_each(const Blocks& blocks, const ParticleBlock& b, F&& f) {
        for (std::uint32_t l = b.first_link; l < b.last_link; ++l) f(values[blocks.links[l].at], blocks.links[l].node);
    }
    void clear(const Blocks& blocks, const ParticleBlock& b) {
        for_each(blocks, b, [](Value& v, std::uint32_t) { v = Value(0); });
    }
    void load(const Blocks& blocks, const ParticleBlock& b, const Pages<Value>& from) {
        for_each(blocks, b, [&](Value& v, std::uint32_t n) { v = from[n]; });
    }
    void add_to(const Blocks& blocks, const ParticleBlock& b, Pages<Value>& to) {
        for_each(blocks, b, [&](Value& v, std::uint32_t n) { to[n] += v; });
    }
};

/// Calls add(block) for every block, several at once, which adds to the nodes that the block is linked to. The order of
/// the sums is fixed: colour after colour, and no two blocks of one colour share a node.
template <class F> void scatter_blocks(const Blocks& blocks, F&& add) {
#pragma omp parallel
    for (const std::vector<std::uint32_t>& colour : blocks.colours) {
        const auto count = static_cast<std::ptrdiff_t>(colour.size());
#pragma omp for schedule(dynamic)
        for (std::ptrdiff_t c = 0; c < count; ++c) add(blocks.particle_blocks[colour[c]]);
    }
}

/// Nodes and how they differ from the one before along z: with Σ_k w_k = 1, a sum Σ_k w_k N_k is N₀ + Σ_k W_k (N_k − N_{k−1})
/// with W_k = w_k + w_{k+1} + …, which takes one product less, two with a derivative's; what moves alike has no slope to
/// the bit.
template <class Value, int stencil_width> struct SlopedTile {
    Tile<Value, stencil_width> nodes, steps;

    void load(const Blocks& blocks, const ParticleBlock& b, const Pages<Value>& from) {
        constexpr int width = Tile<Value, stencil_width>::width;
        nodes.load(blocks, b, from);
        for (int row = 0; row < width * width; ++row)
            for (int k = 1; k < width; ++k) steps.values[row * width + k] = nodes.values[row * width + k] - nodes.values[row * width + k - 1];
    }
};

/// Calls gather(number of the block, tile) for every block awake with its nodes in a sloped tile, several at once.
template <int stencil_width, class Value, class F>
void gather_blocks(const Blocks& blocks, const Pages<Value>& nodes, F&& gather) {
    const auto count = static_cast<std::ptrdiff_t>(blocks.particle_blocks.size());
#pragma omp parallel for schedule(dynamic)
    for (std::ptrdiff_t b = 0; b < count; ++b) {
        if (blocks.particle_blocks[b].asleep()) continue;
        SlopedTile<Value, stencil_width> tile;
        tile.load(blocks, blocks.particle_blocks[b], nodes);
        gather(std::size_t(b), tile);
    }
}

}  // namespace firn
