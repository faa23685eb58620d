#pragma once
#include "render/splats.h"

namespace firn {

/// In the order in which spray is drawn: those with puffs before those without, and in either part the grains that are
/// points before those that are lines.
struct SpraySorted {
    struct Part {
        std::size_t first = 0, lines = 0, points_end = 0,
                    end = 0;  ///< points to points_end, lines from `lines` on.
    };
    std::vector<SprayPoint> all;  ///< each twice: for both ends of a line.
    Part with_puffs, without;
};

/// `shutter` [s]; `edge`: samples along a pixel's edge. A particle that may have grains of both kinds is in both.
SpraySorted sorted_spray(const std::vector<SprayPoint>&, const View&, float spacing, float shutter,
                         double edge, float puff_share);

}  // namespace firn
