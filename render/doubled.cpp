#include "render/doubled.h"

#include <algorithm>
#include <cstdint>

namespace firn {

Image doubled(const Image& image, int width, int height) {
    Image result{width, height, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) * height)};
    const std::ptrdiff_t row = 3 * static_cast<std::ptrdiff_t>(image.width);
    const auto next = [](int i, int n) { return std::clamp(i / 2 + (i % 2 ? 1 : -1), 0, n - 1); };
#pragma omp parallel
    {
        std::vector<std::uint16_t> between(
            row + 6);  // of two rows, with a copy of its first and last pixel about it
#pragma omp for
        for (int y = 0; y < height; ++y) {
            const std::uint8_t* near = &image.pixels[y / 2 * row];
            const std::uint8_t* far = &image.pixels[next(y, image.height) * row];
            for (std::ptrdiff_t i = 0; i < row; ++i)
                between[i + 3] = static_cast<std::uint16_t>(3 * near[i] + far[i]);
            std::copy_n(between.begin() + 3, 3, between.begin());
            std::copy_n(between.end() - 6, 3, between.end() - 3);
            std::uint8_t* to = &result.pixels[3 * static_cast<std::size_t>(y) * width];
            for (int x = 0; x < width; ++x) {
                const std::uint16_t *here = &between[3 * (x / 2 + 1)], *there = x % 2 ? here + 3 : here - 3;
                for (int c = 0; c < 3; ++c)
                    to[3 * x + c] = static_cast<std::uint8_t>((3 * here[c] + there[c] + 8) / 16);
            }
        }
    }
    return result;
}

}  // namespace firn
