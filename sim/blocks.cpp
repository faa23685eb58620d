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

bool lexicographic(const Vec3i& a, const Vec3i& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// The nodes that one block's particles reach in each of the 2×2×2 blocks they may reach: 4 dx + 2 dy + dz.
using Reach = std::array<NodeSet, 8>;

/// What a stencil reaches from each of the 64 base nodes.
std::array<Reach, 64> reach_of_bases(int stencil_width) {
    std::array<Reach, 64> table{};
    for (int base = 0; base < 64; ++base)
        for (int i = base >> 4; i < (base >> 4) + stencil_width; ++i)
            for (int j = (base >> 2) & 3; j < ((base >> 2) & 3) + stencil_width; ++j)
                for (int k = base & 3; k < (base & 3) + stencil_width; ++k)
                    table[base][4 * (i >> 2) + 2 * (j >> 2) + (k >> 2)] |= node_bit(i & 3, j & 3, k & 3);
    return table;
}

/// Finds the nodes that the particle blocks reach from these base nodes, numbers them, and links them up.
void link_nodes(Blocks& blocks, const std::vector<NodeSet>& bases, int stencil_width) {
    const std::array<Reach, 64> table = reach_of_bases(stencil_width);
    const std::size_t count = blocks.particle_blocks.size();
    BlockMap reached(2 * count);
    std::vector<Reach> reach(count);
    std::vector<std::array<std::uint32_t, 8>> number(count);
    for (std::size_t b = 0; b < count; ++b) {
        reach[b] = {};
        for (NodeSet left = bases[b]; left != 0; left &= left - 1)
            for (int d = 0; d < 8; ++d) reach[b][d] |= table[std::countr_zero(left)][d];
        for (int d = 0; d < 8; ++d) {
            if (reach[b][d] == 0) continue;
            number[b][d] = reached.number_of(blocks.particle_blocks[b].coordinates + Vec3i(d >> 2, (d >> 1) & 1, d & 1));
            if (number[b][d] == blocks.grid_blocks.size()) blocks.grid_blocks.push_back({reached.blocks().back()});
            blocks.grid_blocks[number[b][d]].nodes |= reach[b][d];
        }
    }
    for (GridBlock& g : blocks.grid_blocks) {
        g.first = static_cast<std::uint32_t>(blocks.nodes);
        blocks.nodes += std::popcount(g.nodes);
    }
    const int width = block_width + stencil_width - 1;
    for (std::size_t b = 0; b < count; ++b) {
        ParticleBlock& block = blocks.particle_blocks[b];
        block.first_link = static_cast<std::uint32_t>(blocks.links.size());
        for (int d = 0; d < 8; ++d)
            for (NodeSet left = reach[b][d]; left != 0; left &= left - 1) {
                const GridBlock& g = blocks.grid_blocks[number[b][d]];
                const NodeSet before = (left & -left) - 1;
                const int n = std::countr_zero(left);
                const int i = 4 * (d >> 2) + (n >> 4), j = 4 * ((d >> 1) & 1) + ((n >> 2) & 3), k = 4 * (d & 1) + (n & 3);
                blocks.links.push_back({g.first + std::popcount(g.nodes & before),
                                        static_cast<std::uint32_t>((i * width + j) * width + k)});
            }
        block.last_link = static_cast<std::uint32_t>(blocks.links.size());
    }
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

Blocks arrange(const std::vector<Run>& runs, std::size_t particles, int stencil_width) {
    // Number the blocks as they come, then rank them by their coordinates.
    BlockMap occupied(runs.size() / 8 + 64);
    std::vector<std::uint32_t> block_of(runs.size());
    for (std::size_t r = 0; r < runs.size(); ++r) block_of[r] = occupied.number_of(runs[r].block);
    const std::vector<Vec3i>& found = occupied.blocks();
    std::vector<std::uint32_t> by_rank(found.size()), rank(found.size());
    std::iota(by_rank.begin(), by_rank.end(), 0);
    std::sort(by_rank.begin(), by_rank.end(),
              [&](std::uint32_t a, std::uint32_t b) { return lexicographic(found[a], found[b]); });
    for (std::size_t i = 0; i < by_rank.size(); ++i) rank[by_rank[i]] = static_cast<std::uint32_t>(i);

    Blocks result;
    std::vector<std::uint32_t> next(found.size() + 1, 0);
    std::vector<NodeSet> bases(found.size(), 0);
    for (std::size_t r = 0; r < runs.size(); ++r) {
        next[rank[block_of[r]] + 1] += runs[r].end - runs[r].begin;
        bases[rank[block_of[r]]] |= runs[r].bases;
    }
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::size_t i = 0; i < by_rank.size(); ++i)
        result.particle_blocks.push_back({found[by_rank[i]], next[i], next[i + 1], 0, 0});

    // Where the runs are not in that order already: which particle goes where.
    bool in_order = true;
    for (std::size_t r = 1; r < runs.size(); ++r) in_order &= rank[block_of[r - 1]] <= rank[block_of[r]];
    if (!in_order) {
        result.order.resize(particles);
        for (std::size_t r = 0; r < runs.size(); ++r) {
            std::uint32_t& at = next[rank[block_of[r]]];
            std::iota(result.order.begin() + at, result.order.begin() + at + (runs[r].end - runs[r].begin),
                      runs[r].begin);
            at += runs[r].end - runs[r].begin;
        }
    }

    for (std::uint32_t i = 0; i < result.particle_blocks.size(); ++i) {
        const Vec3i& c = result.particle_blocks[i].coordinates;
        result.colours[4 * (c.x() & 1) + 2 * (c.y() & 1) + (c.z() & 1)].push_back(i);
    }
    link_nodes(result, bases, stencil_width);
    return result;
}

}  // namespace firn
