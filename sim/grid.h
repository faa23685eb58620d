#pragma once
#include "sim/blocks.h"
#include "sim/bspline.h"
#include "sim/particles.h"

#include <algorithm>
#include <utility>

namespace firn {

/// A node. After rasterize:  (m v, m | f, 0).  After update:  (vⁿ⁺¹, m | vⁿ, 0), under APIC (vⁿ⁺¹, m | vⁿ⁺¹, 0).
template <class Real> using Node = Pack<Real, 8>;
/// A vector at a node, for the linear solve: x y z 0.
template <class Real> using NodeVector = Pack<Real, 4>;

/// The nodes under the particles: a flat array, block after block; in a block z runs fastest.
template <class Real> struct Grid {
    Real h = 0;                             ///< [m]
    Blocks blocks;
    std::vector<Node<Real>> nodes;

    std::size_t size() const { return blocks.nodes(); }
    /// World position of node `n` of the flat array [m].
    Vec3d position(std::size_t n) const {
        const int local = static_cast<int>(n % block_nodes);
        const Vec3i offset(local >> 4, (local >> 2) & 3, local & 3);
        return double(h) * (4 * blocks.grid_blocks[n / block_nodes].cast<double>() + offset.cast<double>());
    }
};

/// The nodes that one block's particles reach, side by side, so that a stencil is a plain triple loop.
template <class Value, int stencil_width> struct Tile {
    static constexpr int width = block_width + stencil_width - 1;
    Value values[width * width * width];

    static constexpr int index(int i, int j, int k) { return (i * width + j) * width + k; }

    /// Calls f(value of the tile, index in the flat array) for all of them.
    template <class F> void for_each(const ParticleBlock& b, F&& f) {
        for (int i = 0; i < width; ++i)
            for (int j = 0; j < width; ++j) {
                const int row = 4 * (i >> 2) + 2 * (j >> 2), within = 16 * (i & 3) + 4 * (j & 3);
                for (int k = 0; k < width; ++k)
                    f(values[index(i, j, k)], std::size_t(b.reach[row + (k >> 2)]) * block_nodes + within + (k & 3));
            }
    }
    void clear() {
        for (Value& v : values) v = Value(0);
    }
    void load(const ParticleBlock& b, const std::vector<Value>& from) {
        for_each(b, [&](Value& v, std::size_t n) { v = from[n]; });
    }
    void add_to(const ParticleBlock& b, std::vector<Value>& to) {
        for_each(b, [&](Value& v, std::size_t n) { to[n] += v; });
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
            tile.clear();
            scatter(b, tile);
            tile.add_to(b, nodes);
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
                tile.load(*current, nodes);
            } else if (p >= current->end) {
                tile.load(*++current, nodes);
            }
            return {tile, *current};
        };
        for (std::ptrdiff_t g = first; g < std::min(first + chunk, groups); ++g) gather(std::size_t(g), tile_of);
    }
}

}  // namespace firn
