#include "render/relief.h"

#include "render/hash.h"

#include <algorithm>
#include <cmath>

namespace firn {

namespace {

constexpr int n = Relief::size;

/// Random values on a lattice of `period` points that repeats, smoothly joined; x and z count lattice cells.
double lattice_noise(double x, double z, int period) {
    const int i = static_cast<int>(std::floor(x)), k = static_cast<int>(std::floor(z));
    const double fx = x - i, fz = z - k;
    const double sx = fx * fx * (3 - 2 * fx), sz = fz * fz * (3 - 2 * fz);
    const auto value = [&](int a, int b) {
        return hash_of(static_cast<std::uint32_t>(period * 65536 + (a % period) * 256 + b % period)) - 0.5;
    };
    const double low = value(i, k) + sx * (value(i + 1, k) - value(i, k));
    const double high = value(i, k + 1) + sx * (value(i + 1, k + 1) - value(i, k + 1));
    return low + sz * (high - low);
}

void normalize(std::vector<double>& values) {
    double squares = 0;
    for (const double v : values) squares += v * v;
    const double deviation = std::sqrt(squares / static_cast<double>(values.size()));
    for (double& v : values) v /= deviation;
}

}  // namespace

Relief snow_relief() {
    std::vector<double> height(n * n), slope_x(n * n), slope_z(n * n);
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i)
            for (int period = 8; period <= 128; period *= 2) {
                const double scale = double(period) / n;
                height[k * n + i] += std::pow(period, -0.9) * lattice_noise(i * scale, k * scale, period);
            }
    const auto at = [&](int i, int k) { return height[((k + n) % n) * n + (i + n) % n]; };
    for (int k = 0; k < n; ++k)
        for (int i = 0; i < n; ++i) {
            slope_x[k * n + i] = at(i + 1, k) - at(i - 1, k);
            slope_z[k * n + i] = at(i, k + 1) - at(i, k - 1);
        }
    Relief relief;
    for (std::vector<double>* values : {&slope_x, &slope_z, &height}) normalize(*values);
    for (int c = 0; c < n * n; ++c)
        for (const double v : {slope_x[c], slope_z[c], height[c], 3.0})
            relief.texels.push_back(
                static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * std::clamp(v / 3, -1.0, 1.0))));
    return relief;
}

}  // namespace firn
