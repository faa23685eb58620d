#pragma once
#include "sim/blocks.h"
#include "sim/bspline.h"
#include "sim/particles.h"

#include <algorithm>
#include <utility>

namespace firn {

/// A node. After rasterize:  (m v, m | f, 0).  After update:  (vⁿ⁺¹, m | vⁿ, 0), under APIC (vⁿ⁺¹, m | vⁿ⁺¹, 0).
template <class Real> using Node = Pack<Real, 8>;

/// The nodes under the particles: a flat array, block after block; in a block z runs fastest.
template <class Real> struct Grid {
    Real h = 0;                             ///< [m]
    Blocks blocks;
    std::vector<Node<Real>> nodes;

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
    Value values[width * width * width];

    static constexpr int index(int i, int j, int k) { return (i * width + j) * width + k; }

    /// Calls f(value of the tile, index in the flat array) for all nodes that the block's particles reach.
    template <class F> void for_each(const Blocks& blocks, const ParticleBlock& b, F&& f) {
        for (std::uint32_t l = b.first_link; l < b.last_link; ++l) f(values[blocks.links[l].at], blocks.links[l].node);
    }
    void clear(const Blocks& blocks, const ParticleBlock& b) {
        for_each(blocks, b, [](Value& v, std::uint32_t) { v = Value(0); });
    }
    void load(const Blocks& blocks, const ParticleBlock& b, const std::vector<Value>& from) {
        for_each(blocks, b, [&](Value& v, std::uint32_t n) { v = from[n]; });
    }
    void add_to(const Blocks& blocks, const ParticleBlock& b, std::vector<Value>& to) {
        for_each(blocks, b, [&](Value& v, std::uint32_t n) { to[n] += v; });
    }
};

/// Calls scatter(block, tile) for every block with a cleared tile, and adds the tiles up in `nodes`, which
/// must be cleared. The order of the sums is fixed: colour after colour, and no two blocks of one colour share
/// a node.
template <int stencil_width, class Value, class F>
void scatter_blocks(const Blocks& blocks, std::vector<Value>& nodes, F&& scatter) {
#pragma omp parallel
    for (const std::vector<std::uint32_t>& colour : blocks.colours) {
        const auto count = static_cast<std::ptrdiff_t>(colour.size());
#pragma omp for schedule(dynamic)
        for (std::ptrdiff_t c = 0; c < count; ++c) {
            const ParticleBlock& b = blocks.particle_blocks[colour[c]];
            Tile<Value, stencil_width> tile;
            tile.clear(blocks, b);
            scatter(b, tile);
            tile.add_to(blocks, b, nodes);
        }
    }
}

constexpr int groups_per_chunk = 64;  ///< that one thread gathers on end.

/// Calls gather(group, tiles) for every group of eight particles, where tiles(p) is the loaded tile of particle
/// p's block. Neighbouring groups mostly share it, so it is loaded about once a block.
template <int stencil_width, class Value, class F>
void gather_groups(const Blocks& blocks, std::size_t particles, const std::vector<Value>& nodes, F&& gather) {
    constexpr std::ptrdiff_t chunk = groups_per_chunk;
    const auto groups = static_cast<std::ptrdiff_t>((particles + lanes - 1) / lanes);
    const std::vector<ParticleBlock>& all = blocks.particle_blocks;
#pragma omp parallel for schedule(dynamic)
    for (std::ptrdiff_t first = 0; first < groups; first += chunk) {
        Tile<Value, stencil_width> tile;
        const ParticleBlock* current = nullptr;
        const auto tile_of = [&](std::size_t p) -> std::pair<const Tile<Value, stencil_width>&, const ParticleBlock&> {
            if (!current) {
                current = &*std::upper_bound(all.begin(), all.end(), p, [](std::size_t q, const ParticleBlock& b) {
                    return q < b.end; });
                tile.load(blocks, *current, nodes);
            } else if (p >= current->end) {
                tile.load(blocks, *++current, nodes);
            }
            return {tile, *current};
        };
        for (std::ptrdiff_t g = first; g < std::min(first + chunk, groups); ++g) gather(std::size_t(g), tile_of);
    }
}

}  // namespace firn
