#pragma once
#include "sim/types.h"

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

/// A stretch of consecutive particles that belong to the same block.
struct Run {
    Vec3i block;
    std::uint32_t begin, end;
    NodeSet bases;                          ///< the base nodes of their stencils.
};

/// A node that a block's particles reach.
struct Link {
    std::uint32_t node;                     ///< index in the grid's flat array.
    std::uint32_t at;                       ///< index in the block's tile, whose rows are as wide as all stencils.
};

/// A block with particles in it.
struct ParticleBlock {
    Vec3i coordinates;                      ///< block (i, j, k) begins at node 4 (i, j, k).
    std::uint32_t begin, end;               ///< its particles.
    std::uint32_t first_link, last_link;    ///< its nodes, in Blocks::links.
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

/// Blocks for particles that lie in these runs, and the order that particles must be brought into.
struct Blocks {
    std::vector<ParticleBlock> particle_blocks;             ///< in lexicographic order of coordinates.
    std::array<std::vector<std::uint32_t>, 8> colours;      ///< of them, those with the same parities.
    std::vector<GridBlock> grid_blocks;
    std::vector<Link> links;
    std::vector<std::uint32_t> order;                       ///< old places of the particles; empty: as they are.
    std::size_t nodes = 0;
};

/// Particles keep their order within a block, so that sums over them do not depend on who computed the runs.
/// `stencil_width`: nodes along each axis that a particle reaches, at most 4.
Blocks arrange(const std::vector<Run>& runs, std::size_t particles, int stencil_width);

}  // namespace firn
