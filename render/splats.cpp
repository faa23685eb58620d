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

/// How whole the snow around a particle is, 0 in the air to 1; ρ is the smoothed density, of which a single
/// particle makes about 0.03 and the face of unbroken snow has a half.
float wholeness(float rho) { return smoothstep(0.05f, 0.27f, rho); }

float radius_of(float spacing, float whole, float hash) {
    return spacing * 0.85f * whole * (0.75f + 0.5f * hash);
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

/// Mean of the particles' values in every cell; empty where they have none.
Field mean_values(const ParticleView& particles, const Density& density) {
    if (particles.value.empty()) return {};
    Field sum{density.rho.size, std::vector<float>(density.rho.values.size(), 0.0f)}, count = sum;
    for (std::size_t p = 0; p < particles.size(); ++p) {
        const float* at = &particles.x[3 * p];
        if (!drawable(at)) continue;
        const Vector3f u = cell_coordinates({at[0], at[1], at[2]}, density);
        if (!(u.array() >= 0).all() || !(u.array() < sum.size.cast<float>().array()).all()) continue;
        const std::size_t c = sum.index(int(u.x()), int(u.y()), int(u.z()));
        sum.values[c] += particles.value[p], count.values[c] += 1;
    }
    for (std::size_t c = 0; c < sum.values.size(); ++c) sum.values[c] /= std::max(count.values[c], 1.0f);
    return sum;
}

/// Adds the hidden cells of a slice that touch one which is not: the plugs. Half a cell's diagonal is 0.87.
template <class Add>
void add_plugs(const Density& density, const Field& least, const Field& values, int k, Add add) {
    const Eigen::Vector3i n = density.rho.size;
    const auto inner = [&](int i, int j, int l) { return least.values[least.index(i, j, l)] >= solid; };
    for (int j = 1; j < n.y() - 1; ++j)
        for (int i = 1; i < n.x() - 1; ++i) {
            if (!inner(i, j, k)) continue;
            const bool enclosed = inner(i - 1, j, k) && inner(i + 1, j, k) && inner(i, j - 1, k) &&
                                  inner(i, j + 1, k) && inner(i, j, k - 1) && inner(i, j, k + 1);
            if (enclosed) continue;
            const Vector3f x = density.origin + density.cell * Vector3f(i + 0.5f, j + 0.5f, k + 0.5f);
            add(Splat{x.x(), x.y(), x.z(), 0.62f * density.cell, 0.5f,
                      values.values.empty() ? 0 : values.values[values.index(i, j, k)]});
        }
}

/// Whether a ball may be in the picture.
bool in_picture(const Vector3f& x, float radius, const View& view) {
    const Vector3f p = view.basis.transpose() * (x - view.eye);
    const Eigen::Vector2f half = 0.5f * view.sample_tan * view.samples.cast<float>();
    return p.z() + radius > view.near_depth && std::abs(p.x()) < half.x() * (p.z() + radius) + 2 * radius &&
           std::abs(p.y()) < half.y() * (p.z() + radius) + 2 * radius;
}

/// How much of a cloud a loose particle is: 0 at rest, a crumb; 1 where it moves on by its own size at once.
float flight(const ParticleView& particles, std::size_t p) {
    constexpr float at_once = 0.01f;  // [s]
    if (particles.v.empty() || !drawable(&particles.v[3 * p])) return 0;
    const Vector3f v(particles.v[3 * p], particles.v[3 * p + 1], particles.v[3 * p + 2]);
    return smoothstep(0.3f, 1.5f, v.norm() * at_once / particles.spacing);
}

SprayPoint spray_point(const ParticleView& particles, std::size_t p, float amount, float hash) {
    SprayPoint point{particles.x[3 * p],
                     particles.x[3 * p + 1],
                     particles.x[3 * p + 2],
                     0,
                     0,
                     0,
                     amount,
                     hash,
                     particles.value.empty() ? 0 : particles.value[p]};
    if (particles.v.empty() || !drawable(&particles.v[3 * p])) return point;
    point.vx = particles.v[3 * p], point.vy = particles.v[3 * p + 1], point.vz = particles.v[3 * p + 2];
    return point;
}

/// What a piece of the particles gives.
struct Piece {
    std::vector<Splat> near, far, covered;
    std::vector<SprayPoint> spray;
    float nearest = INFINITY;
};

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

Splats visible_splats(const ParticleView& particles, const Density& density, const Density& soft,
                      const View& view, float near_radius) {
    const Field least = smallest_around(density.rho), values = mean_values(particles, density);
    const auto hidden = [&](const Vector3f& x) {
        return nearest(least, cell_coordinates(x, density)) >= solid;
    };

    // Pieces of fixed size, joined in their order: the same splats for every number of threads.
    constexpr std::size_t piece_size = 16384;
    const auto particle_pieces = static_cast<int>((particles.size() + piece_size - 1) / piece_size);
    std::vector<Piece> pieces(particle_pieces + std::max(density.rho.size.z() - 2, 0));
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i) {
        Piece& piece = pieces[i];
        const auto add = [&](const Splat& splat) {
            const Vector3f x(splat.x, splat.y, splat.z);
            const float depth = view.basis.col(2).dot(x - view.eye);
            if (!in_picture(x, splat.radius, view) || is_covered(x, view.eye, density)) {
                piece.covered.push_back(splat);
                return;
            }
            piece.nearest = std::min(piece.nearest, depth);
            if (splat.radius > near_radius * view.sample_tan * depth)
                piece.near.push_back(splat);
            else
                piece.far.push_back(splat);
        };
        if (i >= particle_pieces) {
            add_plugs(density, least, values, i - particle_pieces + 1, add);
            continue;
        }
        const std::size_t first = i * piece_size, last = std::min(particles.size(), first + piece_size);
        for (std::size_t p = first; p < last; ++p) {
            const float* at = &particles.x[3 * p];
            const Vector3f x(at[0], at[1], at[2]);
            if (!drawable(at) || hidden(x)) continue;
            const float hash = hash_of(static_cast<std::uint32_t>(p)), whole = wholeness(soft.at(x)),
                        flying = flight(particles, p);
            if (const float amount = (1 - whole) * (0.5f + 0.5f * flying); amount > 0.15f)
                piece.spray.resize(piece.spray.size() + 2, spray_point(particles, p, amount, hash));
            if (const float solid_share = std::max(whole, 0.42f * (1 - flying)); solid_share > 0.02f)
                add({at[0], at[1], at[2], radius_of(particles.spacing, solid_share, hash), hash,
                     particles.value.empty() ? 0 : particles.value[p]});
        }
    }

    Splats splats;
    for (const Piece& piece : pieces) append(splats.all, piece.near);
    splats.near = splats.all.size();
    for (const Piece& piece : pieces) append(splats.all, piece.far);
    splats.seen = splats.all.size();
    for (const Piece& piece : pieces) {
        append(splats.all, piece.covered);
        append(splats.spray, piece.spray);
        splats.nearest = std::min(splats.nearest, piece.nearest);
    }
    return splats;
}

}  // namespace firn
