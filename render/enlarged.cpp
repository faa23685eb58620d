#include "render/enlarged.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace firn {

namespace {

/// Two neighbouring samples along an axis, and the second one's weight [1/16].
struct Between {
    int first, second, weight;
};

std::vector<Between> places(int pixels, int samples, double edge) {
    std::vector<Between> result(pixels);
    for (int i = 0; i < pixels; ++i) {
        const double at =
            std::clamp((i + 0.5 - 0.5 * pixels) * edge + 0.5 * samples - 0.5, 0.0, samples - 1.0);
        const int first = static_cast<int>(at);
        result[i] = {first, std::min(first + 1, samples - 1),
                     static_cast<int>(std::lround(16 * (at - first)))};
    }
    return result;
}

}  // namespace

Image enlarged(const Image& samples, int width, int height, double edge) {
    Image result{width, height, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) * height)};
    const std::ptrdiff_t row = 3 * static_cast<std::ptrdiff_t>(samples.width);
    const std::vector<Between> across = places(width, samples.width, edge),
                               down = places(height, samples.height, edge);
#pragma omp parallel
    {
        std::vector<std::uint16_t> between(row);  // of two rows; 16 · 16 · 255 is still a number of 16 bits
#pragma omp for
        for (int y = 0; y < height; ++y) {
            const std::uint8_t *a = &samples.pixels[down[y].first * row],
                               *b = &samples.pixels[down[y].second * row];
            const int weight = down[y].weight;
            for (std::ptrdiff_t i = 0; i < row; ++i)
                between[i] = static_cast<std::uint16_t>((16 - weight) * a[i] + weight * b[i]);
            std::uint8_t* to = &result.pixels[3 * static_cast<std::size_t>(y) * width];
            for (const Between& x : across) {
                const std::uint16_t *left = &between[3 * x.first], *right = &between[3 * x.second];
                for (int c = 0; c < 3; ++c)
                    *to++ = static_cast<std::uint8_t>(
                        ((16 - x.weight) * left[c] + x.weight * right[c] + 128) / 256);
            }
        }
    }
    return result;
}

}  // namespace firn
