#pragma once
#include "render/picture.h"

#include <array>
#include <cstdint>
#include <string>

namespace firn {

/// sRGB of a share from 0 to 1: viridis, in which equal steps look equal; for a compression, blue over grey to
/// red, grey at the middle.
std::array<std::uint8_t, 3> mapped_colour(Colour, double share);

/// What stands beside the colour map, with its unit: "speed [m/s]".
std::string colour_title(Colour);

/// The values at a colour map's ends.
struct ColourRange {
    double low, high;
    /// 0 to 1; values outside are at the ends.
    double share(double value) const;
};

}  // namespace firn
