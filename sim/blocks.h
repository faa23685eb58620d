#pragma once
#include "sim/pack.h"
#include "sim/types.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace firn {

// The grid is sparse: of blocks of 4×4×4 nodes it holds those nodes which particles reach, and no others. A
// particle belongs to the block that holds its base node; its stencil ends in that block or in one of the seven
// that follow it along the axes. So a block's particles write to 2×2×2 blocks, and blocks whose coordinates have
// the same parities (the same one of eight colours) never write to the same node.

constexpr int block_width = 4;

/// A set of a block's nodes: bit 16 i + 4 j + k stands for node (i, j, k).
using NodeSet = std::uint64_t;
inline NodeSet node_bit(int i, int j, int k) { return NodeSet(1) << (16 * i + 4 * j + k); }

/// A node that a block's particles reach.
struct Link {
    std::uint32_t node;                     ///< index in the grid's flat array.
    std::uint32_t at;                       ///< index in the block's tile, whose rows are as wide as all stencils.
};

/// A block with particles in it: particle n of them is in slot n % 8 of group groups[n / 8]. Its groups are full but
/// for the last one.
struct ParticleBlock {
    Vec3i coordinates;                      ///< block (i, j, k) begins at node 4 (i, j, k).
    std::uint32_t count = 0;                ///< its particles.
    std::vector<std::uint32_t> groups{};    ///< of Particles.
    NodeSet bases = 0;                      ///< the base nodes of its particles' stencils.
    double quiet = 0;                       ///< how long all of them have been slow [s].
    std::int32_t lump = -1;                 ///< asleep: which of Particles' lumps it is.
    std::uint32_t first_link = 0, last_link = 0;    ///< its nodes, in Blocks::links.

    bool asleep() const { return lump >= 0; }
    std::size_t slot(std::uint32_t n) const { return std::size_t(lanes) * groups[n / lanes] + n % lanes; }
    /// Particles in group g of it.
    int count_in(std::size_t g) const { return static_cast<int>(std::min<std::size_t>(lanes, count - lanes * g)); }
};

/// A block with nodes in it; they lie in the flat array one behind the other.
struct GridBlock {
    Vec3i coordinates;
    std::uint32_t first = 0;                ///< index of its first node.
    NodeSet nodes = 0;
};

/// Finds blocks by their coordinates.
class BlockMap {
public:
    explicit BlockMap(std::size_t expected);
    /// Its number, from 0 on in the order of first calls.
    std::uint32_t number_of(const Vec3i& coordinates);
    const std::vector<Vec3i>& blocks() const { return blocks_; }

private:
    void grow();
    std::vector<Vec3i> blocks_;
    std::vector<std::uint32_t> slots_;      ///< number + 1, or 0; open addressing, at most half full.
};

/// All blocks of a moment.
struct Blocks {
    std::vector<ParticleBlock> particle_blocks;             ///< in lexicographic order of coordinates.
    std::array<std::vector<std::uint32_t>, 8> colours;      ///< of them, those with the same parities.
    std::vector<GridBlock> grid_blocks;
    std::vector<Link> links;
    std::size_t nodes = 0;

    /// Takes blocks as they come, without those that are empty, and finds everything else: the nodes that their
    /// particles reach from their base nodes, numbered and linked. `stencil_width`: nodes along each axis that a
    /// particle reaches, at most 4.
    void link(std::vector<ParticleBlock>&&, int stencil_width);

    /// Calls f(slot) for every particle, block after block: the same order wherever the groups are.
    template <class F> void for_each_particle(F&& f) const {
        for (const ParticleBlock& b : particle_blocks)
            for (std::uint32_t n = 0; n < b.count; ++n) f(b.slot(n));
    }
};

}  // namespace firn
