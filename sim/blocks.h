#pragma once
#include "sim/types.h"

#include <array>
#include <cstdint>
#include <vector>

namespace firn {

// The grid is sparse: blocks of 4×4×4 nodes, which exist where particles reach them. A particle belongs to the
// block that holds its base node; its stencil ends in that block or in one of the seven that follow it along
// the axes. So a block's particles write to 2×2×2 blocks, and blocks whose coordinates have the same parities
// (the same one of eight colours) never write to the same node.

constexpr int block_width = 4;
constexpr int block_nodes = 64;

/// A stretch of consecutive particles that belong to the same block.
struct Run {
    Vec3i block;
    std::uint32_t begin, end;
};

/// A block with particles in it.
struct ParticleBlock {
    Vec3i coordinates;                      ///< block (i, j, k) begins at node 4 (i, j, k).
    std::uint32_t begin, end;               ///< its particles.
    std::array<std::uint32_t, 8> reach;     ///< grid blocks at +(0|1, 0|1, 0|1): index 4 dx + 2 dy + dz.
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
    std::vector<Vec3i> grid_blocks;                         ///< coordinates of every block that is reached.
    std::vector<std::uint32_t> order;                       ///< old places of the particles; empty: as they are.
    std::size_t nodes() const { return grid_blocks.size() * block_nodes; }
};

/// Particles keep their order within a block, so that sums over them do not depend on who computed the runs.
Blocks arrange(const std::vector<Run>& runs, std::size_t particles);

}  // namespace firn
