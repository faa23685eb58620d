#include "render/light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace firn {

using Eigen::Vector3f;
using Eigen::Vector3i;

/// Slices across the axis nearest to the light's direction are passed from the lit side on. With l the way
/// from a slice to the one before it, and x' the point of that one which the light passes:
///   τ(x) = τ(x') + l (ρ(x) + ρ(x')) / 2.
/// Rows along x lie in one piece: with `rows_whole` they are cut only where the light runs along them.
Field thickness_towards(const Density& density, float spacing, const Vector3f& to_light, float most,
                        bool rows_whole) {
    const Vector3i n = density.rho.size;
    int axis = 0;
    const Vector3f share = to_light.cwiseAbs().cwiseProduct(Vector3f(rows_whole ? 0.5f : 1.0f, 1, 1));
    share.maxCoeff(&axis);
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;  // u is the faster of the two other axes
    const std::array<std::ptrdiff_t, 3> stride = {1, n.x(), static_cast<std::ptrdiff_t>(n.x()) * n.y()};
    const Vector3f step = to_light / std::abs(to_light[axis]);  // to the slice before, in cells
    const float half_way = 0.5f * step.norm() * density.cell / spacing;
    const int du = static_cast<int>(std::floor(step[u])), dv = static_cast<int>(std::floor(step[v]));
    const float fu = step[u] - static_cast<float>(du), fv = step[v] - static_cast<float>(dv);

    // The slice before, as τ' + l ρ'/2, three cells wider on each side by its own rim, where snow is thin.
    const int rim = 3, width = n[u] + 2 * rim, height = n[v] + 2 * rim;
    std::vector<float> before(static_cast<std::size_t>(width) * height, 0.0f);
    Field tau{n, std::vector<float>(density.rho.values.size())};
    for (int s = 0; s < n[axis]; ++s) {
        const int slice = to_light[axis] > 0 ? n[axis] - 1 - s : s;
        const float* rho = density.rho.values.data() + slice * stride[axis];
        float* out = tau.values.data() + slice * stride[axis];
        const auto pass_row = [&](int j, auto along) {
            const float* row0 = &before[static_cast<std::size_t>(j + rim + dv) * width + rim + du];
            const float* row1 = row0 + width;
            const std::ptrdiff_t row = j * stride[v];
            for (int i = 0; i < n[u]; ++i) {
                const float a = row0[i] + fu * (row0[i + 1] - row0[i]);
                const float b = row1[i] + fu * (row1[i + 1] - row1[i]);
                out[row + i * along] = std::min(a + fv * (b - a) + half_way * rho[row + i * along], most);
            }
        };
        for (int j = 0; j < n[v]; ++j) {
            if (u == 0)  // the compiler must know the stride of one to do eight at a time
                pass_row(j, std::integral_constant<std::ptrdiff_t, 1>());
            else
                pass_row(j, stride[u]);
        }
        for (int j = 0; j < height; ++j) {
            const std::ptrdiff_t row = std::clamp(j - rim, 0, n[v] - 1) * stride[v];
            float* copy = &before[static_cast<std::size_t>(j) * width];
            for (int i = 0; i < n[u]; ++i)
                copy[rim + i] = out[row + i * stride[u]] + half_way * rho[row + i * stride[u]];
            for (int i = 0; i < rim; ++i) {
                copy[i] = copy[rim];
                copy[rim + n[u] + i] = copy[rim + n[u] - 1];
            }
        }
    }
    return tau;
}

namespace {

struct SkyDirection {
    Vector3f to_sky;
    float weight;
};

/// The zenith, four directions half way up and four low ones between them; the weights add up to one.
std::array<SkyDirection, 9> sky_directions() {
    std::array<SkyDirection, 9> result;
    result[0] = {{0, 1, 0}, 0.20f};
    for (int i = 0; i < 8; ++i) {
        const bool low = i % 2;
        const float azimuth = (static_cast<float>(i) + 0.3f) * std::numbers::pi_v<float> / 4;
        const float elevation = low ? 0.38f : 0.87f;  // 22° and 50°
        result[i + 1] = {{std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                          std::cos(elevation) * std::sin(azimuth)},
                         low ? 0.08f : 0.12f};
    }
    return result;
}

/// Values of a field of cells twice as wide, in the middle of a row's cells: three quarters from the nearest,
/// one from the next, along every axis.
void interpolate_row(const Field& coarse, int j, int k, int count, float* out) {
    const auto next = [](int i, int n) { return std::clamp(i / 2 + (i % 2 ? 1 : -1), 0, n - 1); };
    const Vector3i n = coarse.size;
    const float* near_near = &coarse.values[coarse.index(0, j / 2, k / 2)];
    const float* far_near = &coarse.values[coarse.index(0, next(j, n.y()), k / 2)];
    const float* near_far = &coarse.values[coarse.index(0, j / 2, next(k, n.z()))];
    const float* far_far = &coarse.values[coarse.index(0, next(j, n.y()), next(k, n.z()))];
    const auto across = [&](int i) {
        return 0.5625f * near_near[i] + 0.1875f * (far_near[i] + near_far[i]) + 0.0625f * far_far[i];
    };
    for (int i = 0; i < count; ++i) out[i] = 0.75f * across(i / 2) + 0.25f * across(next(i, n.x()));
}

/// The sky that is seen, summed over its directions; it changes slowly, so that coarse cells do.
Field sky_seen(const Density& density, float spacing) {
    constexpr float k = 0.12f;  // per particle spacing
    const Density coarse = halved(density);
    const auto directions = sky_directions();
    std::array<Field, 9> tau;
#pragma omp parallel for schedule(dynamic)
    for (int d = 0; d < 9; ++d) tau[d] = thickness_towards(coarse, spacing, directions[d].to_sky);
    Field sky{coarse.rho.size, std::vector<float>(coarse.rho.values.size(), 0.0f)};
    const auto count = static_cast<std::ptrdiff_t>(sky.values.size());
#pragma omp parallel for
    for (std::ptrdiff_t i = 0; i < count; ++i)
        for (int d = 0; d < 9; ++d) sky.values[i] += directions[d].weight / (1 + k * tau[d].values[i]);
    return sky;
}

}  // namespace

/// Snow scatters light on rather than swallowing it, so neither law falls like exp(−τ).
///   sky:  Σ 1/(1 + k τ) over the sky;   sun:  1/(1 + c τ)², with blue going farthest.
std::vector<SnowLight> light_in_snow(const Density& density, float spacing, const Vector3f& to_sun) {
    constexpr float c[3] = {0.050f, 0.042f, 0.036f};  // per particle spacing
    const Field sky = sky_seen(density, spacing), tau = thickness_towards(density, spacing, to_sun);
    const Vector3i n = density.rho.size;
    std::vector<SnowLight> light(density.rho.values.size());
#pragma omp parallel
    {
        std::vector<float> row(n.x());
#pragma omp for
        for (int k = 0; k < n.z(); ++k)
            for (int j = 0; j < n.y(); ++j) {
                interpolate_row(sky, j, k, n.x(), row.data());
                const std::size_t first = density.rho.index(0, j, k);
                for (int i = 0; i < n.x(); ++i) {
                    const auto through = [&](float extinction) {
                        const float t = 1 + extinction * tau.values[first + i];
                        return Eigen::half(1 / (t * t));
                    };
                    light[first + i] = {{through(c[0]), through(c[1]), through(c[2])}, Eigen::half(row[i])};
                }
            }
    }
    return light;
}

}  // namespace firn
