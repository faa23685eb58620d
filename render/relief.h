#pragma once
#include <cstdint>
#include <vector>

namespace firn {

/// Unevenness of a snow-covered ground, on a square that repeats without a seam.
struct Relief {
    static constexpr int size = 256;  ///< texels along an edge.
    /// Each of half the size, down to one texel: drivers that make them round in ways of their own. Per texel: slope
    /// along x and along z, then height, then 255; 0 to 255 stands for −3 to 3 standard deviations.
    std::vector<std::vector<std::uint8_t>> levels;
};

/// The same in every run.
Relief snow_relief();

}  // namespace firn
