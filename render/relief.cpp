#include "render/relief.h"

#include "render/hash.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn {

namespace {

constexpr int n = Relief::size;

/// Random slopes at the points of a lattice of `period` points that repeats, smoothly joined [Perlin 2002]; x and z
/// count lattice cells.
double gradient_noise(double x, double z, int period) {
    const int i = static_cast<int>(std::floor(x)), k = static_cast<int>(std::floor(z));
    const double fx = x - i, fz = z - k;
    const auto smooth = [](double f) { return f * f * f * (f * (6 * f - 15) + 10); };
    const auto value = [&](int a, int b) {
        const double turn =
            2 * std::numbers::pi *
            hash_of(static_cast<std::uint32_t>(period * 65536 + ((i + a) % period) * 256 + (k + b) % period));
        return std::cos(turn) * (fx - a) + std::sin(turn) * (fz - b);
    };
    const double low = std::lerp(value(0, 0), value(1, 0), smooth(fx));
    const double high = std::lerp(value(0, 1), value(1, 1), smooth(fx));
    return std::lerp(low, high, smooth(fz));
}

void normalize(std::vector<double>& values) {
    double squares = 0;
    for (const double v : values) squares += v * v;
    const double deviation = std::sqrt(squares / static_cast<double>(values.size()));
    for (double& v : values) v /= deviation;
}

/// Each value the mean of four.
std::vector<double> halved(const std::vector<double>& fine, int size) {
    std::vector<double> coarse;
    for (int k = 0; k < size; k += 2)
        for (int i = 0; i < size; i += 2) {
            const double* corner = &fine[k * size + i];
            coarse.push_back((corner[0] + corner[1] + corner[size] + corner[size + 1]) / 4);
        }
    return coarse;
}

}  // namespace

Relief snow_relief() {
    std::vector<double> height(n * n), slope_x(n * n), slope_z(n * n);
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i)
            for (int period = 8; period <= 128; period *= 2) {
                const double scale = double(period) / n;
                height[k * n + i] += std::pow(period, -0.9) * gradient_noise(i * scale, k * scale, period);
            }
    const auto at = [&](int i, int k) { return height[((k + n) % n) * n + (i + n) % n]; };
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i) {
            slope_x[k * n + i] = at(i + 1, k) - at(i - 1, k);
            slope_z[k * n + i] = at(i, k + 1) - at(i, k - 1);
        }
    Relief relief;
    for (std::vector<double>* values : {&slope_x, &slope_z, &height}) normalize(*values);
    for (int size = n; size > 0; size /= 2) {
        std::vector<std::uint8_t>& texels = relief.levels.emplace_back();
        for (int c = 0; c < size * size; ++c)
            for (const double v : {slope_x[c], slope_z[c], height[c], 3.0})
                texels.push_back(
                    static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::clamp(v / 3, -1.0, 1.0))));
        if (size > 1)
            for (std::vector<double>* values : {&slope_x, &slope_z, &height}) *values = halved(*values, size);
    }
    return relief;
}

}  // namespace firn
