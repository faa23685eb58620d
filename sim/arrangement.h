#pragma once
#include "sim/bspline.h"
#include "sim/grid.h"
#include "sim/particles.h"
#include "sim/rest.h"

#include <utility>

namespace firn {

/// The block of a base node (an integer), and which of its nodes that is.
template <class Real> std::pair<Vec3i, NodeSet> block_of(const Vec3<Real>& base) {
    const int i = int(base(0)), j = int(base(1)), k = int(base(2));
    return {{i >> 2, j >> 2, k >> 2}, node_bit(i & 3, j & 3, k & 3)};
}

/// Whether base nodes are so far out that Real does not tell sixteenths of a cell apart there, or are no numbers.
template <class Real> bool lost(const Vec3<Real>& base) {
    constexpr Real farthest = sizeof(Real) == 4 ? Real(1 << 20) : Real(2e9);
    return !(base.cwiseAbs().maxCoeff() < farthest) || base.hasNaN();
}

/// Blocks for n particles at x(p), which must not be lost, and slots for them: slots[p].
struct Arrangement {
    std::vector<ParticleBlock> blocks;
    std::vector<std::uint32_t> slots;
    std::size_t groups = 0;
};
template <Weights kind, class Real, class Position> Arrangement arrange(std::size_t n, Real h, Position&& x) {
    Arrangement r;
    BlockMap map(n / 256);
    std::vector<std::uint32_t> rank(n);
    r.slots.resize(n);
    for (std::size_t p = 0; p < n; ++p) {
        const auto [block, base] = block_of(Place<kind, Real>(x(p), h).base);
        const std::uint32_t b = map.number_of(block);
        if (b == r.blocks.size()) r.blocks.push_back({.coordinates = block});
        r.slots[p] = b, rank[p] = r.blocks[b].count++;
        r.blocks[b].bases |= base;
    }
    for (ParticleBlock& b : r.blocks)
        for (std::uint32_t g = 0; g < b.count; g += lanes) b.groups.push_back(static_cast<std::uint32_t>(r.groups++));
    for (std::size_t p = 0; p < n; ++p) r.slots[p] = static_cast<std::uint32_t>(r.blocks[r.slots[p]].slot(rank[p]));
    return r;
}

/// A particle that has left its block, and its slot there.
template <class Real> struct Departure {
    Vec3i block;            ///< where it is now.
    NodeSet base;
    typename Particles<Real>::One particle;
    std::size_t slot = 0;   ///< that it gets there.
};

/// Takes particle n out of a block; the last one fills the gap. The block keeps its groups.
template <class Real> [[gnu::noinline]] typename Particles<Real>::One take_out(Particles<Real>& ps, ParticleBlock& b, std::uint32_t n) {
    const std::size_t gap = b.slot(n), last = b.slot(--b.count);
    const typename Particles<Real>::One one = ps.get(gap);
    if (last != gap) ps.put(gap, ps.get(last));
    ps.empty(last);
    return one;
}

/// Puts what was taken out of the blocks (`departures` of each) to where it is now, in a fixed order; all else stays in
/// its slot.
template <class Real>
void migrate(Particles<Real>& ps, Blocks& blocks, std::vector<std::vector<Departure<Real>>>& departures, int stencil_width) {
    std::vector<ParticleBlock> all = std::move(blocks.particle_blocks);
    BlockMap map(all.size());
    for (ParticleBlock& b : all) {
        map.number_of(b.coordinates);
        for (; b.groups.size() * lanes >= b.count + lanes; b.groups.pop_back()) ps.free_groups.push_back(b.groups.back());
    }
    for (auto& of_block : departures)
        for (Departure<Real>& d : of_block) {
            const std::uint32_t to = map.number_of(d.block);
            if (to == all.size()) all.push_back({.coordinates = d.block});
            ParticleBlock& target = all[to];
            if (target.asleep()) wake(ps, target);
            if (target.count % lanes == 0) target.groups.push_back(ps.new_group());
            target.bases |= d.base;
            d.slot = target.slot(target.count++);
        }
    const auto count = static_cast<std::ptrdiff_t>(departures.size());
#pragma omp parallel for schedule(dynamic, 16)
    for (std::ptrdiff_t b = 0; b < count; ++b)
        for (const Departure<Real>& d : departures[b]) ps.put(d.slot, d.particle);
    blocks.link(std::move(all), stencil_width);
}

}  // namespace firn
