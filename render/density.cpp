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
    Box3f box{Vector3f::Constant(INFINITY), Vector3f::Constant(-INFINITY)};
    for (std::size_t p = 0; p < particles.size(); ++p) {
        const float* x = &particles.x[3 * p];
        if (!drawable(x)) continue;
        box.lower = box.lower.cwiseMin(Vector3f(x[0], x[1], x[2]));
        box.upper = box.upper.cwiseMax(Vector3f(x[0], x[1], x[2]));
    }
    return box.lower.x() > box.upper.x() ? Box3f{Vector3f::Zero(), Vector3f::Zero()} : box;
}

/// Holds all but a share of `left_out` of the particles at either end of each axis.
Box3f quantiles_of(const ParticleView& particles, double left_out) {
    const std::size_t step = particles.size() / 65536 + 1;  // 2¹⁶ particles at even steps tell enough
    std::array<std::vector<float>, 3> values;
    for (std::size_t p = 0; p < particles.size(); p += step)
        if (drawable(&particles.x[3 * p]))
            for (int a = 0; a < 3; ++a) values[a].push_back(particles.x[3 * p + a]);
    Box3f box{Vector3f::Zero(), Vector3f::Zero()};
    if (values[0].empty()) return box;
    for (int a = 0; a < 3; ++a) {
        auto& v = values[a];
        const auto rank = static_cast<std::size_t>(left_out * static_cast<double>(v.size()));
        std::sort(v.begin(), v.end());
        box.lower[a] = v[rank];
        box.upper[a] = v[v.size() - 1 - rank];
    }
    return box;
}

/// Cells of the box, in double as it may be too large for anything else.
Eigen::Vector3d cells_of(const Box3f& box, double cell) {
    return ((box.upper.cast<double>() / cell).array().floor() -
            (box.lower.cast<double>() / cell).array().floor()) +
           1 + 2 * padding;
}

template <class Combine>
Field filtered(Field field, Combine combine) {
    const Vector3i n = field.size;
    const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(n.x()),
                                               static_cast<std::size_t>(n.x()) * n.y()};
    std::vector<float> result(field.values.size());
    for (int axis = 0; axis < 3; ++axis) {
        const std::size_t s = stride[axis];
#pragma omp parallel for
        for (int k = 0; k < n.z(); ++k)
            for (int j = 0; j < n.y(); ++j)
                for (int i = 0; i < n.x(); ++i) {
                    const int at = axis == 0 ? i : axis == 1 ? j : k;
                    const std::size_t c = field.index(i, j, k);
                    const float before = at > 0 ? field.values[c - s] : 0;
                    const float after = at + 1 < n[axis] ? field.values[c + s] : 0;
                    result[c] = combine(before, field.values[c], after);
                }
        field.values.swap(result);
    }
    return field;
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

}  // namespace

bool drawable(const float* x) {
    constexpr float far_away = 1e5f;  // [m]
    return std::abs(x[0]) < far_away && std::abs(x[1]) < far_away && std::abs(x[2]) < far_away;
}

Density density_of(const ParticleView& particles, std::size_t max_cells) {
    Density density;
    double cell = 2.0 * particles.spacing;
    Box3f box = bounds_of(particles);
    if (cells_of(box, cell).prod() > static_cast<double>(max_cells)) box = quantiles_of(particles, 0.002);
    while (cells_of(box, cell).prod() > static_cast<double>(max_cells)) cell *= 2;

    density.cell = static_cast<float>(cell);
    density.origin = (((box.lower.cast<double>() / cell).array().floor() - padding) * cell).cast<float>();
    density.rho.size = cells_of(box, cell).cast<int>();
    density.rho.values.assign(static_cast<std::size_t>(cells_of(box, cell).prod()), 0.0f);

    // One thread: a fixed order of the sums.
    const float share = static_cast<float>(std::pow(particles.spacing / cell, 3));
    float* rho = density.rho.values.data();
    const std::size_t dy = static_cast<std::size_t>(density.rho.size.x()), dz = dy * density.rho.size.y();
    for (std::size_t p = 0; p < particles.size(); ++p) {
        const float* x = &particles.x[3 * p];
        if (!drawable(x)) continue;
        const Corner corner = corner_of(density, {x[0], x[1], x[2]});
        if (!corner.inside) continue;
        const Vector3f f = corner.f, g = Vector3f::Ones() - f;
        float* at = rho + density.rho.index(corner.cell.x(), corner.cell.y(), corner.cell.z());
        for (int k = 0; k < 2; ++k)
            for (int j = 0; j < 2; ++j) {
                const float w = share * (k ? f.z() : g.z()) * (j ? f.y() : g.y());
                at[k * dz + j * dy] += w * g.x();
                at[k * dz + j * dy + 1] += w * f.x();
            }
    }
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

Field smallest_around(const Field& field) {
    return filtered(field, [](float a, float b, float c) { return std::min(a, std::min(b, c)); });
}

Field smoothed(const Field& field) {
    return filtered(field, [](float a, float b, float c) { return 0.25f * (a + 2 * b + c); });
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
