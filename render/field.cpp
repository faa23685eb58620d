#include "render/field.h"

#include <algorithm>

namespace firn {

using Eigen::Vector3i;

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
    const Vector3i n = field.size;
    Field result{n, std::vector<float>(field.values.size())};
    const std::vector<float> zeros(n.x(), 0.0f);
#pragma omp parallel
    {
        std::vector<float> sum(n.x() + 2, 0.0f);  // of nine rows, with zero before and after
#pragma omp for
        for (int k = 0; k < n.z(); ++k)
            for (int j = 0; j < n.y(); ++j) {
                const auto row = [&](int dj, int dk) {
                    const bool inside = j + dj >= 0 && j + dj < n.y() && k + dk >= 0 && k + dk < n.z();
                    return inside ? &field.values[field.index(0, j + dj, k + dk)] : zeros.data();
                };
                const float *a = row(-1, -1), *b = row(0, -1), *c = row(1, -1), *d = row(-1, 0),
                            *e = row(0, 0), *f = row(1, 0), *g = row(-1, 1), *h = row(0, 1), *l = row(1, 1);
                for (int i = 0; i < n.x(); ++i)
                    sum[i + 1] =
                        4 * e[i] + 2 * ((b[i] + h[i]) + (d[i] + f[i])) + ((a[i] + c[i]) + (g[i] + l[i]));
                float* to = &result.values[result.index(0, j, k)];
                for (int i = 0; i < n.x(); ++i) to[i] = (sum[i] + 2 * sum[i + 1] + sum[i + 2]) / 64;
            }
    }
    return result;
}

std::vector<Eigen::half> outward_of(const Field& rho) {
    const Vector3i n = rho.size;
    std::vector<Eigen::half> result(4 * rho.values.size());
#pragma omp parallel for
    for (int k = 0; k < n.z(); ++k)
        for (int j = 0; j < n.y(); ++j) {
            const auto row = [&](int dj, int dk) {
                return &rho.values[rho.index(0, std::clamp(j + dj, 0, n.y() - 1),
                                             std::clamp(k + dk, 0, n.z() - 1))];
            };
            const float *here = row(0, 0), *below = row(-1, 0), *above = row(1, 0), *behind = row(0, -1),
                        *before = row(0, 1);
            Eigen::half* to = &result[4 * rho.index(0, j, k)];
            for (int i = 0; i < n.x(); ++i) {
                const Eigen::Array4f values(here[std::max(i - 1, 0)] - here[std::min(i + 1, n.x() - 1)],
                                            below[i] - above[i], behind[i] - before[i], here[i]);
                Eigen::Map<Eigen::Array<Eigen::half, 4, 1>>(to + 4 * i) = values.cast<Eigen::half>();
            }
        }
    return result;
}

}  // namespace firn
