#include "render/density.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace firn {

namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr int padding = 6;  ///< empty cells on every side, over which light comes in and shade fades out.

struct Box3f {
    Vector3f lower, upper;
};

Box3f bounds_of(const ParticleView& particles) {
    constexpr std::ptrdiff_t piece = 16384;
    const auto count = static_cast<std::ptrdiff_t>(particles.size());
    Box3f box{Vector3f::Constant(INFINITY), Vector3f::Constant(-INFINITY)};
#pragma omp parallel for
    for (std::ptrdiff_t first = 0; first < count; first += piece) {
        Box3f mine{Vector3f::Constant(INFINITY), Vector3f::Constant(-INFINITY)};
        for (std::ptrdiff_t p = first; p < std::min(count, first + piece); ++p) {
            const float* x = &particles.x[3 * p];
            if (!drawable(x)) continue;
            mine.lower = mine.lower.cwiseMin(Vector3f(x[0], x[1], x[2]));
            mine.upper = mine.upper.cwiseMax(Vector3f(x[0], x[1], x[2]));
        }
#pragma omp critical
        box = {box.lower.cwiseMin(mine.lower), box.upper.cwiseMax(mine.upper)};
    }
    return box.lower.x() > box.upper.x() ? Box3f{Vector3f::Zero(), Vector3f::Zero()} : box;
}

/// Holds all but a share of `left_out` of the particles at either end of each axis.
Box3f quantiles_of(const ParticleView& particles, double left_out) {
    const std::size_t step = particles.size() / 32768 + 1;  // 2¹⁵ particles at even steps tell enough
    std::array<std::vector<float>, 3> values;
    for (std::size_t p = 0; p < particles.size(); p += step)
        if (drawable(&particles.x[3 * p]))
            for (int a = 0; a < 3; ++a) values[a].push_back(particles.x[3 * p + a]);
    Box3f box{Vector3f::Zero(), Vector3f::Zero()};
    if (values[0].empty()) return box;
    for (int a = 0; a < 3; ++a) {
        auto& v = values[a];
        const auto rank = static_cast<std::size_t>(left_out * static_cast<double>(v.size()));
        const auto low = v.begin() + static_cast<std::ptrdiff_t>(rank),
                   high = v.end() - 1 - static_cast<std::ptrdiff_t>(rank);
        std::nth_element(v.begin(), low, v.end());
        box.lower[a] = *low;
        std::nth_element(v.begin(), high, v.end());
        box.upper[a] = *high;
    }
    return box;
}

/// Cells of the box, an even number of them, in double as it may be too large for anything else.
Eigen::Vector3d cells_of(const Box3f& box, double cell) {
    const Eigen::Vector3d cells = ((box.upper.cast<double>() / cell).array().floor() -
                                   (box.lower.cast<double>() / cell).array().floor()) +
                                  1 + 2 * padding;
    return 2 * (cells / 2).array().ceil();
}

/// Adds some of the particles: to eight cells each, by where it is between their centres.
void add_particles(Density& density, const float* x, std::ptrdiff_t count, float share) {
    float* rho = density.rho.values.data();
    const std::ptrdiff_t dy = density.rho.size.x(), dz = dy * density.rho.size.y();
    const Vector3f first = density.origin + Vector3f::Constant(0.5f * density.cell);
    const Vector3f last = (density.rho.size.array() - 1).cast<float>();
    const float per_cell = 1 / density.cell;
    constexpr std::ptrdiff_t many = 128;
    std::array<std::int32_t, many> cell;
    std::array<float, many> fu, fv, fw;
    for (std::ptrdiff_t start = 0; start < count; start += many) {
        const std::ptrdiff_t here = std::min(many, count - start);
        const float* at = x + 3 * start;
        for (std::ptrdiff_t p = 0; p < here; ++p) {  // as many at once as the processor can
            const float u = (at[3 * p] - first.x()) * per_cell, v = (at[3 * p + 1] - first.y()) * per_cell,
                        w = (at[3 * p + 2] - first.z()) * per_cell;
            const bool inside =
                (u >= 0) & (u < last.x()) & (v >= 0) & (v < last.y()) & (w >= 0) & (w < last.z());
            const float u0 = inside ? u : 0, v0 = inside ? v : 0, w0 = inside ? w : 0;
            const auto i = static_cast<std::int32_t>(u0), j = static_cast<std::int32_t>(v0),
                       k = static_cast<std::int32_t>(w0);
            fu[p] = u0 - static_cast<float>(i), fv[p] = v0 - static_cast<float>(j),
            fw[p] = w0 - static_cast<float>(k);
            cell[p] = inside ? static_cast<std::int32_t>(k * dz + j * dy + i) : -1;
        }
        for (std::ptrdiff_t p = 0; p < here; ++p) {
            if (cell[p] < 0) continue;
            float* row = rho + cell[p];
            const float upper = share * fw[p], lower = share - upper;
            const float d = upper * fv[p], c = upper - d, b = lower * fv[p], a = lower - b;
            const float u = fu[p];
            row[0] += a - a * u, row[1] += a * u;
            row[dy] += b - b * u, row[dy + 1] += b * u;
            row[dz] += c - c * u, row[dz + 1] += c * u;
            row[dz + dy] += d - d * u, row[dz + dy + 1] += d * u;
        }
    }
}

/// Each part of the particles is added up on its own, then the parts: the same sums for any number of threads.
void add_particles(Density& density, const ParticleView& particles, float share) {
    const auto count = static_cast<std::ptrdiff_t>(particles.size());
    std::array<Density, 4> parts;
    parts[0] = std::move(density);
#pragma omp parallel for schedule(static, 1)
    for (int i = 0; i < 4; ++i) {
        Density& part = parts[i];
        if (i > 0) part = {parts[0].origin, parts[0].cell, {parts[0].rho.size, {}}};
        part.rho.values.assign(part.rho.size.cast<std::size_t>().prod(), 0.0f);
        const std::ptrdiff_t start = i * count / 4, end = (i + 1) * count / 4;
        add_particles(part, particles.x.data() + 3 * start, end - start, share);
    }
    density = std::move(parts[0]);
    float* sum = density.rho.values.data();
    const float *b = parts[1].rho.values.data(), *c = parts[2].rho.values.data(),
                *d = parts[3].rho.values.data();
#pragma omp parallel for
    for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(density.rho.values.size()); ++i)
        sum[i] = (sum[i] + b[i]) + (c[i] + d[i]);
}

}  // namespace

Density density_of(const ParticleView& particles, std::size_t max_cells) {
    Density density;
    double cell = 2.0 * particles.spacing;
    Box3f box = bounds_of(particles);
    const Box3f inner =
        quantiles_of(particles, 0.002);  // a few particles in the air shall not cost light for all of it
    const auto too_large = [&] {
        const Eigen::Vector3d cells = cells_of(box, cell);
        return cells.prod() > static_cast<double>(max_cells) || cells.maxCoeff() > longest_edge;
    };
    if (too_large() || cells_of(inner, cell).prod() < 0.75 * cells_of(box, cell).prod()) box = inner;
    while (too_large()) cell *= std::exp2(0.25);

    density.cell = static_cast<float>(cell);
    density.origin = (((box.lower.cast<double>() / cell).array().floor() - padding) * cell).cast<float>();
    density.rho.size = cells_of(box, cell).cast<int>();
    add_particles(density, particles, static_cast<float>(std::pow(particles.spacing / cell, 3)));
    return density;
}

void Density::at(const float* x, const float* y, const float* z, std::size_t count, float* result) const {
    const Vector3f first = origin + Vector3f::Constant(0.5f * cell),
                   last = (rho.size.array() - 1).cast<float>();
    const float per_cell = 1 / cell;
    const std::int32_t dy = rho.size.x(), dz = dy * rho.size.y();
    const float* v = rho.values.data();
    for (std::size_t p = 0; p < count; ++p) {  // as many at once as the processor can
        const float u = (x[p] - first.x()) * per_cell, t = (y[p] - first.y()) * per_cell,
                    w = (z[p] - first.z()) * per_cell;
        const bool inside = (u >= 0) & (u < last.x()) & (t >= 0) & (t < last.y()) & (w >= 0) & (w < last.z());
        const float u0 = inside ? u : 0, t0 = inside ? t : 0, w0 = inside ? w : 0;
        const auto i = static_cast<std::int32_t>(u0), j = static_cast<std::int32_t>(t0),
                   k = static_cast<std::int32_t>(w0);
        const float fu = u0 - static_cast<float>(i), ft = t0 - static_cast<float>(j),
                    fw = w0 - static_cast<float>(k);
        const std::int32_t c = k * dz + j * dy + i;
        const auto along = [&](std::int32_t at) { return v[at] + fu * (v[at + 1] - v[at]); };
        const float near = along(c) + ft * (along(c + dy) - along(c)),
                    far = along(c + dz) + ft * (along(c + dz + dy) - along(c + dz));
        result[p] = inside ? near + fw * (far - near) : 0;
    }
}

Density halved(const Density& density) {
    const Vector3i fine = density.rho.size, n = (fine.array() + 1) / 2;
    Density coarse{density.origin, 2 * density.cell, {n, std::vector<float>(n.cast<std::size_t>().prod())}};
#pragma omp parallel
    {
        std::vector<float> sum(2 * n.x());
#pragma omp for
        for (int k = 0; k < n.z(); ++k)
            for (int j = 0; j < n.y(); ++j) {
                std::fill(sum.begin(), sum.end(), 0.0f);
                for (int l = 2 * k; l < std::min(2 * k + 2, fine.z()); ++l)
                    for (int m = 2 * j; m < std::min(2 * j + 2, fine.y()); ++m) {
                        const float* row = &density.rho.values[density.rho.index(0, m, l)];
                        for (int i = 0; i < fine.x(); ++i) sum[i] += row[i];
                    }
                float* to = &coarse.rho.values[coarse.rho.index(0, j, k)];
                for (int i = 0; i < n.x(); ++i) to[i] = 0.125f * (sum[2 * i] + sum[2 * i + 1]);
            }
    }
    return coarse;
}

}  // namespace firn
