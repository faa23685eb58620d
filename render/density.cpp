#include "render/density.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

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

/// One axis of a filter; zero lies outside.
void smooth_along(int axis, const Field& from, std::vector<float>& to) {
    const Vector3i n = from.size;
    const std::vector<float> zeros(n.x(), 0.0f);
#pragma omp parallel for
    for (int k = 0; k < n.z(); ++k)
        for (int j = 0; j < n.y(); ++j) {
            const float* row = &from.values[from.index(0, j, k)];
            float* result = &to[from.index(0, j, k)];
            if (axis == 0) {
                for (int i = 1; i < n.x() - 1; ++i)
                    result[i] = 0.25f * (row[i - 1] + 2 * row[i] + row[i + 1]);
                for (const int i : {0, n.x() - 1})
                    result[i] =
                        0.25f * ((i > 0 ? row[i - 1] : 0) + 2 * row[i] + (i + 1 < n.x() ? row[i + 1] : 0));
                continue;
            }
            const int at = axis == 1 ? j : k;
            const std::ptrdiff_t stride = axis == 1 ? n.x() : static_cast<std::ptrdiff_t>(n.x()) * n.y();
            const float* before = at > 0 ? row - stride : zeros.data();
            const float* after = at + 1 < n[axis] ? row + stride : zeros.data();
            for (int i = 0; i < n.x(); ++i) result[i] = 0.25f * (before[i] + 2 * row[i] + after[i]);
        }
}

/// The lower corner of the eight cells around a point, and where it is between their centres.
struct Corner {
    Vector3i cell;
    Vector3f f;
    bool inside;
};

Corner corner_of(const Density& density, const Vector3f& x) {
    const Vector3f u = (x - density.origin) / density.cell - Vector3f::Constant(0.5f);
    const Vector3f floor = u.array().floor();
    const bool inside =
        (floor.array() >= 0).all() && (floor.array() < density.rho.size.cast<float>().array() - 1).all();
    if (!inside) return {Vector3i::Zero(), Vector3f::Zero(), false};
    return {floor.cast<int>(), u - floor, true};
}

/// Slices of the grid, shared out so that each thread has about as many particles.
std::vector<int> shared_slices(const Density& density, const ParticleView& particles, int threads) {
    std::vector<std::size_t> count(density.rho.size.z() + 1, 1);
    for (std::size_t p = 0; p < particles.size(); p += 64) {
        const float* x = &particles.x[3 * p];
        if (drawable(x))
            ++count[std::clamp((x[2] - density.origin.z()) / density.cell, 0.0f,
                               float(density.rho.size.z()))];
    }
    const std::size_t all = std::accumulate(count.begin(), count.end(), std::size_t(0));
    std::vector<int> ends{0};
    std::size_t sum = 0;
    for (int k = 0; k < density.rho.size.z(); ++k) {
        sum += count[k];
        if (sum * threads >= all * ends.size() && static_cast<int>(ends.size()) < threads)
            ends.push_back(k + 1);
    }
    ends.push_back(density.rho.size.z());
    return ends;
}

/// Every thread goes through all particles and adds to slices of its own: the order of each sum is that of the
/// particles, for any number of threads.
void add_particles(Density& density, const ParticleView& particles, float share) {
    const std::vector<int> ends = shared_slices(density, particles, std::min(omp_get_max_threads(), 8));
    float* rho = density.rho.values.data();
    const std::size_t dy = static_cast<std::size_t>(density.rho.size.x()), dz = dy * density.rho.size.y();
    const Vector3f first = density.origin + Vector3f::Constant(0.5f * density.cell);
    const Vector3f last = (density.rho.size.array() - 1).cast<float>();
    const float per_cell = 1 / density.cell, *x = particles.x.data();
    const auto count = static_cast<std::ptrdiff_t>(particles.size());
#pragma omp parallel for schedule(static, 1)
    for (std::size_t piece = 0; piece < ends.size() - 1; ++piece) {
        const float lower = static_cast<float>(ends[piece] - 1), upper = static_cast<float>(ends[piece + 1]);
        for (std::ptrdiff_t p = 0; p < count; ++p) {
            const float w = (x[3 * p + 2] - first.z()) * per_cell;
            if (!(w >= lower && w < upper && w >= 0 && w < last.z())) continue;
            const float u = (x[3 * p] - first.x()) * per_cell, v = (x[3 * p + 1] - first.y()) * per_cell;
            if (!(u >= 0 && u < last.x() && v >= 0 && v < last.y())) continue;
            const int i = static_cast<int>(u), j = static_cast<int>(v), k = static_cast<int>(w);
            const float fu = u - static_cast<float>(i), fv = v - static_cast<float>(j),
                        fw = w - static_cast<float>(k);
            float* at = rho + density.rho.index(i, j, k);
            const auto add_slice = [&](float* slice, float part) {
                slice[0] += part * (1 - fv) * (1 - fu);
                slice[1] += part * (1 - fv) * fu;
                slice[dy] += part * fv * (1 - fu);
                slice[dy + 1] += part * fv * fu;
            };
            if (k >= ends[piece]) add_slice(at, share * (1 - fw));
            if (k + 1 < ends[piece + 1]) add_slice(at + dz, share * fw);
        }
    }
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
    while (too_large()) cell *= 2;

    density.cell = static_cast<float>(cell);
    density.origin = (((box.lower.cast<double>() / cell).array().floor() - padding) * cell).cast<float>();
    density.rho.size = cells_of(box, cell).cast<int>();
    density.rho.values.assign(static_cast<std::size_t>(cells_of(box, cell).prod()), 0.0f);

    add_particles(density, particles, static_cast<float>(std::pow(particles.spacing / cell, 3)));
    return density;
}

float Density::at(const Vector3f& x) const {
    const Corner corner = corner_of(*this, x);
    if (!corner.inside) return 0;
    const Vector3f f = corner.f;
    float sum = 0;
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j) {
            const float* v =
                &rho.values[rho.index(corner.cell.x(), corner.cell.y() + j, corner.cell.z() + k)];
            sum += (k ? f.z() : 1 - f.z()) * (j ? f.y() : 1 - f.y()) * (v[0] + f.x() * (v[1] - v[0]));
        }
    return sum;
}

std::vector<std::uint8_t> enclosed_cells(const Field& field, float least) {
    const Vector3i n = field.size;
    std::vector<std::uint8_t> cells(field.values.size()), result(cells.size());
    const std::vector<std::uint8_t> zeros(n.x(), 0);
#pragma omp parallel for
    for (int k = 0; k < n.z(); ++k)
        for (int j = 0; j < n.y(); ++j) {
            const float* row = &field.values[field.index(0, j, k)];
            std::uint8_t* to = &cells[field.index(0, j, k)];
            for (int i = 1; i < n.x() - 1; ++i)
                to[i] = (row[i - 1] >= least) & (row[i] >= least) & (row[i + 1] >= least);
        }
    for (const int axis : {1, 2}) {
        const std::ptrdiff_t stride = axis == 1 ? n.x() : static_cast<std::ptrdiff_t>(n.x()) * n.y();
#pragma omp parallel for
        for (int k = 0; k < n.z(); ++k)
            for (int j = 0; j < n.y(); ++j) {
                const int at = axis == 1 ? j : k;
                const std::uint8_t* row = &cells[field.index(0, j, k)];
                const std::uint8_t* before = at > 0 ? row - stride : zeros.data();
                const std::uint8_t* after = at + 1 < n[axis] ? row + stride : zeros.data();
                std::uint8_t* to = &result[field.index(0, j, k)];
                for (int i = 0; i < n.x(); ++i) to[i] = before[i] & row[i] & after[i];
            }
        cells.swap(result);
    }
    return cells;
}

Field smoothed(const Field& field) {
    Field result{field.size, std::vector<float>(field.values.size())}, other = result;
    smooth_along(0, field, other.values);
    smooth_along(1, other, result.values);
    smooth_along(2, result, other.values);
    return other;
}

std::vector<Eigen::Vector4f> outward_of(const Field& rho) {
    const Vector3i n = rho.size;
    const auto value = [&](int i, int j, int k) {
        return rho.values[rho.index(std::clamp(i, 0, n.x() - 1), std::clamp(j, 0, n.y() - 1),
                                    std::clamp(k, 0, n.z() - 1))];
    };
    std::vector<Eigen::Vector4f> result(rho.values.size());
#pragma omp parallel for
    for (int k = 0; k < n.z(); ++k)
        for (int j = 0; j < n.y(); ++j)
            for (int i = 0; i < n.x(); ++i)
                result[rho.index(i, j, k)] = {value(i - 1, j, k) - value(i + 1, j, k),
                                              value(i, j - 1, k) - value(i, j + 1, k),
                                              value(i, j, k - 1) - value(i, j, k + 1), value(i, j, k)};
    return result;
}

}  // namespace firn
