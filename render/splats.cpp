#include "render/splats.h"

#include "render/hash.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace firn {

namespace {

using Eigen::Vector3f;

constexpr float solid = 0.5f;  ///< density from which a cell hides what is behind it.

float smoothstep(float a, float b, float x) {
    const float t = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/// Spray is fine powder, unbroken snow is closed.
float radius_of(float spacing, float rho, float hash) {
    return spacing * 0.85f * (0.42f + 0.58f * smoothstep(0.02f, 0.5f, rho)) * (0.75f + 0.5f * hash);
}

Eigen::Vector3f cell_coordinates(const Vector3f& x, const Density& density) {
    return (x - density.origin) / density.cell;
}

/// Nearest cell's value, zero outside; u counts cells.
float nearest(const Field& field, const Vector3f& u) {
    const Eigen::Vector3i n = field.size;
    if (!(u.array() >= 0).all() || !(u.array() < n.cast<float>().array()).all()) return 0;
    return field.values[field.index(int(u.x()), int(u.y()), int(u.z()))];
}

}  // namespace

bool is_covered(const Vector3f& splat, const Vector3f& eye, const Density& density) {
    const Vector3f u = cell_coordinates(splat, density), to_eye = (eye - splat).stableNormalized();
    for (const float cells : {1.0f, 2.0f, 3.0f})
        if (nearest(density.rho, u + cells * to_eye) < 0.75f) return false;
    return (eye - splat).norm() > 4 * density.cell;
}

namespace {

/// Adds the hidden cells of a slice that touch one which is not: the plugs. Half a cell's diagonal is 0.87.
template <class Add>
void add_plugs(const Density& density, const Field& least, int k, Add add) {
    const Eigen::Vector3i n = density.rho.size;
    const auto inner = [&](int i, int j, int l) { return least.values[least.index(i, j, l)] >= solid; };
    for (int j = 1; j < n.y() - 1; ++j)
        for (int i = 1; i < n.x() - 1; ++i) {
            if (!inner(i, j, k)) continue;
            const bool enclosed = inner(i - 1, j, k) && inner(i + 1, j, k) && inner(i, j - 1, k) &&
                                  inner(i, j + 1, k) && inner(i, j, k - 1) && inner(i, j, k + 1);
            if (enclosed) continue;
            const Vector3f x = density.origin + density.cell * Vector3f(i + 0.5f, j + 0.5f, k + 0.5f);
            add(Splat{x.x(), x.y(), x.z(), 0.62f * density.cell, 0.5f});
        }
}

}  // namespace

Splats visible_splats(const ParticleView& particles, const Density& density, const Vector3f& eye) {
    const Field least = smallest_around(density.rho);
    const auto hidden = [&](const Vector3f& x) {
        return nearest(least, cell_coordinates(x, density)) >= solid;
    };

    // Pieces of fixed size, joined in their order: the same splats for every number of threads.
    constexpr std::size_t piece = 16384;
    const auto particle_pieces = static_cast<int>((particles.size() + piece - 1) / piece);
    const int pieces = particle_pieces + std::max(density.rho.size.z() - 2, 0);
    std::vector<std::array<std::vector<Splat>, 2>> lists(pieces);  // seen, covered
#pragma omp parallel for schedule(dynamic)
    for (int list = 0; list < pieces; ++list) {
        const auto add = [&](const Splat& splat) {
            lists[list][is_covered({splat.x, splat.y, splat.z}, eye, density)].push_back(splat);
        };
        if (list >= particle_pieces) {
            add_plugs(density, least, list - particle_pieces + 1, add);
            continue;
        }
        for (std::size_t p = list * piece; p < std::min(particles.size(), (list + 1) * piece); ++p) {
            const float* at = &particles.x[3 * p];
            const Vector3f x(at[0], at[1], at[2]);
            if (!drawable(at) || hidden(x)) continue;
            const float hash = hash_of(static_cast<std::uint32_t>(p));
            add({at[0], at[1], at[2], radius_of(particles.spacing, density.at(x), hash), hash});
        }
    }

    Splats splats;
    for (const int covered : {0, 1}) {
        for (const auto& list : lists)
            splats.all.insert(splats.all.end(), list[covered].begin(), list[covered].end());
        if (!covered) splats.seen = splats.all.size();
    }
    return splats;
}

}  // namespace firn
