#pragma once
#include <cstdint>
#include <vector>

namespace firn {

/// 8-bit sRGB picture, rows from the top, RGB interleaved: pixels.size() = 3 · width · height.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> pixels;
};

}  // namespace firn
