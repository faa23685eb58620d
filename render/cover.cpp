#include "render/cover.h"

#include "render/light.h"

#include <algorithm>

namespace firn {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr float solid = 0.5f;  ///< density from which a cell hides what is behind it.

Cover::Cover(const Density& density)
    : origin(density.origin),
      cell(density.cell),
      size(density.rho.size),
      blocks((size.array() + 3) / 4),
      cells(density.rho.values.size()),
      any(blocks.cast<std::size_t>().prod()) {
#pragma omp parallel for
    for (int b = 0; b < blocks.z(); ++b)
        for (int k = 4 * b; k < std::min(4 * b + 4, size.z()); ++k)
            for (int j = 0; j < size.y(); ++j) {
                const std::size_t first = density.rho.index(0, j, k);
                const float* rho = &density.rho.values[first];
                std::uint8_t* to = &cells[first];
                for (int i = 0; i < size.x(); ++i)
                    to[i] = static_cast<std::uint8_t>(
                        static_cast<int>(std::clamp(200 * rho[i] - 100, 0.0f, 100.0f)));
                std::uint8_t* block = &any[(static_cast<std::size_t>(b) * blocks.y() + j / 4) * blocks.x()];
                for (int i = 0; i < size.x(); ++i) block[i / 4] |= to[i];
            }
    for (int k = 0; k < blocks.z(); ++k)
        for (int j = 0; j < blocks.y(); ++j)
            for (int i = 0; i < blocks.x(); ++i)
                if (any[(static_cast<std::size_t>(k) * blocks.y() + j) * blocks.x() + i]) {
                    const Eigen::Vector3i lower = 4 * Eigen::Vector3i(i, j, k);
                    filled.extend(lower.cast<float>());
                    filled.extend((lower.array() + 4).min(size.array()).cast<float>().matrix());
                }
}

/// The face of snow, which has half its density, does not count: one may look along it.
bool Cover::covers(const Vector3f& x, const Vector3f& direction, float distance, float from_cells) const {
    const Vector3f u = (x - origin) / cell, d = direction;
    float end = std::min(distance / cell, static_cast<float>(size.sum()));
    for (int a = 0; a < 3; ++a) {
        if (d[a] > 1e-6f) end = std::min(end, (filled.max()[a] - u[a]) / d[a]);
        if (d[a] < -1e-6f) end = std::min(end, (filled.min()[a] - u[a]) / d[a]);
        if (!(u[a] >= 0 && u[a] < static_cast<float>(size[a]))) return false;
    }
    int sum = 0;
    for (float t = from_cells; t < end - 1e-3f;) {
        const int i = static_cast<int>(u.x() + t * d.x()), j = static_cast<int>(u.y() + t * d.y()),
                  k = static_cast<int>(u.z() + t * d.z());
        if (!any[(static_cast<std::size_t>(k / 4) * blocks.y() + j / 4) * blocks.x() + i / 4]) {
            t += 3;
            continue;
        }
        sum += cells[(static_cast<std::size_t>(k) * size.y() + j) * size.x() + i];
        if (sum >= 200) return true;
        t += 1;
    }
    return false;
}

bool is_covered(const Vector3f& splat, const Vector3f& eye, const Cover& cover, float from_cells) {
    const Vector3f way = eye - splat;
    const float distance = way.norm();
    return distance > 4 * cover.cell && std::isfinite(distance) &&
           cover.covers(splat, way / distance, distance - cover.cell, from_cells);
}

/// Cells behind at least two, counted from 1.2 cells before them on, of unbroken snow. Thickness spreads to
/// the sides as it is passed on from slice to slice; where it ends at 4, shade grows by less than a cell.
static std::vector<std::uint8_t> unlit_cells(const Density& density, const Vector3f& to_sun) {
    Density firm = density;
    for (float& rho : firm.rho.values) rho = std::clamp(2 * rho - 1, 0.0f, 1.0f);
    firm.rho = thickness_towards(firm, firm.cell, to_sun, 4, true);
    std::vector<std::uint8_t> unlit(firm.rho.values.size());
    for (std::size_t c = 0; c < unlit.size(); ++c) unlit[c] = firm.rho.values[c] >= 3.2f;
    return unlit;
}

HiddenCells::HiddenCells(const Density& density, const Density& soft, const Cover& cover, const Vector3f& eye,
                         const Vector3f& to_sun)
    : cover_(cover), eye_(eye), cells_(enclosed_cells(density.rho, solid)) {
    const std::vector<std::uint8_t> all_whole = enclosed_cells(soft.rho, whole_from),
                                    unlit = unlit_cells(density, to_sun);
    const auto count = static_cast<std::ptrdiff_t>(cells_.size());
#pragma omp parallel for
    for (std::ptrdiff_t c = 0; c < count; ++c)
        cells_[c] = static_cast<std::uint8_t>(not_asked | (unlit[c] ? from_sun : 0) |
                                              (cells_[c] ? enclosed : 0) | (all_whole[c] ? whole : 0));
}

/// Particles are up to a cell's edge nearer than its middle.
std::uint8_t HiddenCells::ask(std::size_t cell) {
    constexpr float from_cells = 1.7f;
    const auto nx = static_cast<std::size_t>(cover_.size.x()), ny = static_cast<std::size_t>(cover_.size.y());
    const Vector3f u(static_cast<float>(cell % nx) + 0.5f, static_cast<float>(cell / nx % ny) + 0.5f,
                     static_cast<float>(cell / nx / ny) + 0.5f);
    const int kind = known(cell) & ~not_asked,
              hidden = kind |
                       (is_covered(cover_.origin + cover_.cell * u, eye_, cover_, from_cells) ? from_eye : 0);
    at(cell).store(static_cast<std::uint8_t>(hidden), std::memory_order_relaxed);
    return static_cast<std::uint8_t>(hidden);
}

/// What hides the next cell on the way to the eye hides this one, too.
int HiddenCells::of_enclosed(int i, int j, int k) {
    const Vector3f u(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f,
                     static_cast<float>(k) + 0.5f);
    const Vector3f x = cover_.origin + cover_.cell * u, next = u + (eye_ - x).normalized();
    const auto index = [&](int a, int b, int c) {
        return (static_cast<std::size_t>(c) * cover_.size.y() + b) * cover_.size.x() + a;
    };
    // An enclosed cell is never at the grid's rim.
    const std::size_t before =
        index(static_cast<int>(next.x()), static_cast<int>(next.y()), static_cast<int>(next.z()));
    const int here = known(index(i, j, k)) & from_sun;
    int hidden = known(before);
    if (hidden & not_asked) hidden = ask(before);
    return here | (hidden & from_eye || is_covered(x, eye_, cover_) ? from_eye : 0);
}

}  // namespace firn
