#include "sim/blocks.h"

#include <algorithm>
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

Blocks arrange(const std::vector<Run>& runs, std::size_t particles) {
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
    for (std::size_t r = 0; r < runs.size(); ++r) next[rank[block_of[r]] + 1] += runs[r].end - runs[r].begin;
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::size_t i = 0; i < by_rank.size(); ++i)
        result.particle_blocks.push_back({found[by_rank[i]], next[i], next[i + 1], {}});

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

    BlockMap reached(2 * found.size());
    for (std::uint32_t i = 0; i < result.particle_blocks.size(); ++i) {
        ParticleBlock& b = result.particle_blocks[i];
        for (int d = 0; d < 8; ++d)
            b.reach[d] = reached.number_of(b.coordinates + Vec3i(d >> 2, (d >> 1) & 1, d & 1));
        const Vec3i& c = b.coordinates;
        result.colours[4 * (c.x() & 1) + 2 * (c.y() & 1) + (c.z() & 1)].push_back(i);
    }
    result.grid_blocks = reached.blocks();
    return result;
}

}  // namespace firn
