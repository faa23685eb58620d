#include "sim/blocks.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace firn {
namespace {

std::size_t hash(const Vec3i& c) {
    const auto mix = [](std::uint64_t a) { return (a ^ (a >> 32)) * 0x9E3779B97F4A7C15u; };
    return mix(mix(mix(static_cast<std::uint32_t>(c.x())) + static_cast<std::uint32_t>(c.y())) +
               static_cast<std::uint32_t>(c.z())) >> 20;
}

/// The nodes that one block's particles reach in each of the 2×2×2 blocks they may reach: 4 dx + 2 dy + dz.
using Reach = std::array<NodeSet, 8>;

/// A set of nodes moved by n along an axis whose neighbours are `unit` bits apart: what stays in the block, and what is
/// in the next one then. `first`: the nodes with 0 along that axis.
NodeSet moved_within(NodeSet a, int n, int unit, NodeSet first) {
    NodeSet room = 0;
    for (int i = 0; i < block_width - n; ++i) room |= first << (unit * i);
    return (a & room) << (unit * n);
}
NodeSet moved_out(NodeSet a, int n, int unit, NodeSet first) {
    NodeSet leaving = 0;
    for (int i = block_width - n; i < block_width; ++i) leaving |= first << (unit * i);
    return (a & leaving) >> (unit * (block_width - n));
}

/// What stencils reach from base nodes: their union over all moves along the axes.
Reach reach_of(NodeSet bases, int stencil_width) {
    constexpr std::array<NodeSet, 3> first{0x000000000000FFFF, 0x000F000F000F000F, 0x1111111111111111};
    constexpr std::array<int, 3> unit{16, 4, 1};
    Reach r{};
    r[0] = bases;
    for (int axis = 0; axis < 3; ++axis) {
        const int bit = 4 >> axis;          // of this axis in the index of Reach
        for (int d = 0; d < 8; ++d) {
            if ((d & bit) != 0 || r[d] == 0) continue;
            const NodeSet a = r[d];
            for (int n = 1; n < stencil_width; ++n)
                r[d] |= moved_within(a, n, unit[axis], first[axis]), r[d | bit] |= moved_out(a, n, unit[axis], first[axis]);
        }
    }
    return r;
}

}  // namespace

BlockMap::BlockMap(std::size_t expected) {
    std::size_t size = 64;
    while (size < 2 * expected) size *= 2;
    slots_.assign(size, 0);
}

std::uint32_t BlockMap::number_of(const Vec3i& coordinates) {
    for (std::size_t slot = hash(coordinates);; ++slot) {
        std::uint32_t& entry = slots_[slot & (slots_.size() - 1)];
        if (entry != 0 && blocks_[entry - 1] == coordinates) return entry - 1;
        if (entry != 0) continue;
        blocks_.push_back(coordinates);
        entry = static_cast<std::uint32_t>(blocks_.size());
        if (2 * blocks_.size() > slots_.size()) grow();
        return static_cast<std::uint32_t>(blocks_.size() - 1);
    }
}

void BlockMap::grow() {
    slots_.assign(2 * slots_.size(), 0);
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
        std::size_t slot = hash(blocks_[i]);
        while (slots_[slot & (slots_.size() - 1)] != 0) ++slot;
        slots_[slot & (slots_.size() - 1)] = static_cast<std::uint32_t>(i + 1);
    }
}

void Blocks::link(std::vector<ParticleBlock>&& all, int stencil_width) {
    std::erase_if(all, [](const ParticleBlock& b) { return b.count == 0; });
    particle_blocks = std::move(all);
    std::sort(particle_blocks.begin(), particle_blocks.end(), [](const ParticleBlock& a, const ParticleBlock& b) {
        return std::lexicographical_compare(a.coordinates.data(), a.coordinates.data() + 3, b.coordinates.data(),
                                            b.coordinates.data() + 3); });
    const std::size_t count = particle_blocks.size();
    for (auto& colour : colours) colour.clear();
    for (std::uint32_t b = 0; b < count; ++b) {
        const Vec3i& c = particle_blocks[b].coordinates;
        colours[4 * (c.x() & 1) + 2 * (c.y() & 1) + (c.z() & 1)].push_back(b);
    }

    std::vector<Reach> reach(count);
    std::vector<std::uint32_t> reached(count + 1, 0);
    const auto blocks = static_cast<std::ptrdiff_t>(count);
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t b = 0; b < blocks; ++b) {
        reach[b] = reach_of(particle_blocks[b].bases, stencil_width);
        for (const NodeSet nodes_of : reach[b]) reached[b + 1] += std::popcount(nodes_of);
    }

    BlockMap map(2 * count);
    grid_blocks.clear();
    std::vector<std::array<std::uint32_t, 8>> number(count);
    for (std::size_t b = 0; b < count; ++b)
        for (int d = 0; d < 8; ++d) {
            if (reach[b][d] == 0) continue;
            number[b][d] = map.number_of(particle_blocks[b].coordinates + Vec3i(d >> 2, (d >> 1) & 1, d & 1));
            if (number[b][d] == grid_blocks.size()) grid_blocks.push_back({map.blocks().back()});
            grid_blocks[number[b][d]].nodes |= reach[b][d];
        }
    nodes = 0;
    for (GridBlock& g : grid_blocks) g.first = static_cast<std::uint32_t>(nodes), nodes += std::popcount(g.nodes);

    std::partial_sum(reached.begin(), reached.end(), reached.begin());
    links.resize(reached.back());
    const int width = block_width + stencil_width - 1;
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t b = 0; b < blocks; ++b) {
        Link* next = &links[reached[b]];
        for (int d = 0; d < 8; ++d)
            for (NodeSet left = reach[b][d]; left != 0; left &= left - 1) {
                const GridBlock& g = grid_blocks[number[b][d]];
                const NodeSet before = (left & -left) - 1;
                const int n = std::countr_zero(left);
                const int i = 4 * (d >> 2) + (n >> 4), j = 4 * ((d >> 1) & 1) + ((n >> 2) & 3), k = 4 * (d & 1) + (n & 3);
                *next++ = {g.first + std::popcount(g.nodes & before), static_cast<std::uint32_t>((i * width + j) * width + k)};
            }
        particle_blocks[b].first_link = reached[b], particle_blocks[b].last_link = reached[b + 1];
    }
}

}  // namespace firn
