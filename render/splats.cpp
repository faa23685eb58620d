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

}  // namespace

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
}

/// The face of snow, which has half its density, does not count: one may look along it.
bool Cover::covers(const Vector3f& x, const Vector3f& direction, float distance, float from_cells) const {
    const Vector3f u = (x - origin) / cell, d = direction;
    float end = std::min(distance / cell, static_cast<float>(size.sum()));
    for (int a = 0; a < 3; ++a) {
        if (d[a] > 1e-6f) end = std::min(end, (static_cast<float>(size[a]) - u[a]) / d[a]);
        if (d[a] < -1e-6f) end = std::min(end, -u[a] / d[a]);
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

/// What particles in a cell are.
enum Hidden : std::uint8_t { from_eye = 1, from_sun = 2, enclosed = 4 };

/// Of every cell that has particles. Those are up to a cell's edge nearer than its middle.
std::vector<std::uint8_t> hidden_cells(const Density& density, const Cover& cover, const Vector3f& eye,
                                       const Vector3f& to_sun) {
    constexpr float from_cells = 1.7f;
    std::vector<std::uint8_t> hidden = enclosed_cells(density.rho, solid);
    const Eigen::Vector3i n = density.rho.size;
#pragma omp parallel for schedule(dynamic)
    for (int k = 0; k < n.z(); ++k)
        for (int j = 0; j < n.y(); ++j)
            for (int i = 0; i < n.x(); ++i) {
                const std::size_t c = density.rho.index(i, j, k);
                if (hidden[c] || density.rho.values[c] == 0) {
                    hidden[c] = hidden[c] ? enclosed : 0;
                    continue;
                }
                const Vector3f x = density.origin + density.cell * Vector3f(i + 0.5f, j + 0.5f, k + 0.5f);
                if (is_covered(x, eye, cover, from_cells)) hidden[c] |= from_eye;
                if (cover.covers(x, to_sun, INFINITY, from_cells)) hidden[c] |= from_sun;
            }
    return hidden;
}

/// Adds the hidden cells of a slice that touch one which is not: the plugs. Half a cell's diagonal is 0.87.
template <class Add>
void add_plugs(const Density& density, const std::vector<std::uint8_t>& hidden, const Field& values, int k,
               Add add) {
    const Eigen::Vector3i n = density.rho.size;
    const auto inner = [&](int i, int j, int l) {
        return (hidden[density.rho.index(i, j, l)] & enclosed) != 0;
    };
    for (int j = 1; j < n.y() - 1; ++j)
        for (int i = 1; i < n.x() - 1; ++i) {
            if (!inner(i, j, k)) continue;
            const bool deep = inner(i - 1, j, k) && inner(i + 1, j, k) && inner(i, j - 1, k) &&
                              inner(i, j + 1, k) && inner(i, j, k - 1) && inner(i, j, k + 1);
            if (deep) continue;
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

/// Of whole snow's radius, what a particle that lies alone has: few are large.
float crumb_share(float hash) {
    const float h = 128 * hash - std::floor(128 * hash);
    return 0.16f + 0.40f * h * h;
}

/// How much of a cloud a loose particle is: 0 at rest, a crumb; 1 where it moves on by its own size at once.
float flight(const ParticleView& particles, std::size_t p) {
    constexpr float at_once = 0.01f;  // [s]
    if (particles.v.empty() || !drawable(&particles.v[3 * p])) return 0;
    const Vector3f v(particles.v[3 * p], particles.v[3 * p + 1], particles.v[3 * p + 2]);
    return smoothstep(0.3f, 1.5f, v.norm() * at_once / particles.spacing);
}

/// `lone`, 0 to 1: in a dense cloud no grain's way can be told from its neighbours'.
SprayPoint spray_point(const ParticleView& particles, std::size_t p, float amount, float lone, float hash) {
    SprayPoint point{particles.x[3 * p],
                     particles.x[3 * p + 1],
                     particles.x[3 * p + 2],
                     0,
                     0,
                     0,
                     amount,
                     hash,
                     particles.value.empty() ? 0 : particles.value[p],
                     0};
    if (particles.v.empty() || !drawable(&particles.v[3 * p])) return point;
    point.vx = lone * particles.v[3 * p], point.vy = lone * particles.v[3 * p + 1],
    point.vz = lone * particles.v[3 * p + 2];
    return point;
}

/// What a piece of the particles gives.
struct Piece {
    std::vector<Splat> near_lit, near_unlit, far_unlit, far_lit, unseen_lit;
    std::vector<SprayPoint> spray;
    float nearest = INFINITY;
};

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

Splats visible_splats(const ParticleView& particles, const Density& density, const Density& soft,
                      const View& view, const Vector3f& to_sun, float near_radius, float least_radius,
                      float least_crumb) {
    const Field values = mean_values(particles, density);
    const Cover cover(density);
    const std::vector<std::uint8_t> hidden = hidden_cells(density, cover, view.eye, to_sun);
    const Vector3f size = density.rho.size.cast<float>();
    const float per_cell = 1 / density.cell;
    const auto hidden_at = [&](const Vector3f& x) -> int {
        const Vector3f u = per_cell * (x - density.origin);
        if (!((u.array() >= 0).all() && (u.array() < size.array()).all())) return 0;
        return hidden[density.rho.index(int(u.x()), int(u.y()), int(u.z()))];
    };

    const float wanted_per_radius = least_radius * view.sample_tan / (0.85f * particles.spacing);
    const auto kept_by = [](float hash) { return 64 * hash - std::floor(64 * hash); };

    // Pieces of fixed size, joined in their order: the same splats for every number of threads.
    constexpr std::size_t piece_size = 16384;
    const auto particle_pieces = static_cast<int>((particles.size() + piece_size - 1) / piece_size);
    std::vector<Piece> pieces(particle_pieces + std::max(density.rho.size.z() - 2, 0));
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i) {
        Piece& piece = pieces[i];
        const auto add = [&](const Splat& splat, int covered) {
            const Vector3f x(splat.x, splat.y, splat.z);
            const bool lit = !(covered & from_sun);
            if (covered & from_eye || !in_picture(x, splat.radius, view)) {
                if (lit) piece.unseen_lit.push_back(splat);
                return;
            }
            const float depth = view.basis.col(2).dot(x - view.eye);
            piece.nearest = std::min(piece.nearest, depth);
            if (splat.radius > near_radius * view.sample_tan * depth)
                (lit ? piece.near_lit : piece.near_unlit).push_back(splat);
            else
                (lit ? piece.far_lit : piece.far_unlit).push_back(splat);
        };
        if (i >= particle_pieces) {
            add_plugs(density, hidden, values, i - particle_pieces + 1, [&](const Splat& plug) {
                const Vector3f x(plug.x, plug.y, plug.z);
                add(plug, (is_covered(x, view.eye, cover) ? from_eye : 0) |
                              (cover.covers(x, to_sun, INFINITY) ? from_sun : 0));
            });
            continue;
        }
        const std::size_t first = i * piece_size, last = std::min(particles.size(), first + piece_size);
        for (std::size_t p = first; p < last; ++p) {
            const float* at = &particles.x[3 * p];
            const Vector3f x(at[0], at[1], at[2]);
            if (!drawable(at)) continue;
            const int covered = hidden_at(x);
            if (covered >= (from_eye | from_sun)) continue;
            // A share of the particles, the same in every frame, covers as much [Cook et al. 2007].
            const float hash = hash_of(static_cast<std::uint32_t>(p)),
                        wanted = wanted_per_radius * (x - view.eye).norm(),
                        share = wanted > 1 ? 1 / (wanted * wanted) : 1;
            const float rho = soft.at(x), whole = wholeness(rho), flying = flight(particles, p);
            const float crumb = radius_of(particles.spacing, crumb_share(hash) * (1 - flying), hash);
            const bool sprayed = whole < crumb_share(hash) * (1 - flying) &&
                                 crumb < least_crumb * view.sample_tan * view.basis.col(2).dot(x - view.eye);
            if (const float amount = (1 - whole) * (0.5f + 0.5f * flying); amount > 0.15f) {
                SprayPoint point = spray_point(particles, p, amount, 1 - smoothstep(0.03f, 0.10f, rho), hash);
                point.crumb = sprayed ? crumb : 0;
                piece.spray.resize(piece.spray.size() + 2, point);
            }
            if (const float radius = std::max(radius_of(particles.spacing, whole, hash), crumb);
                radius > 0.017f * particles.spacing && kept_by(hash) <= share)
                add({at[0], at[1], at[2], radius * std::max(wanted, 1.0f), hash,
                     particles.value.empty() ? 0 : particles.value[p]},
                    covered | (sprayed ? from_eye : 0));
        }
    }

    Splats splats;
    const auto append_all = [&](std::vector<Splat> Piece::*part) {
        for (const Piece& piece : pieces) append(splats.all, piece.*part);
        return splats.all.size();
    };
    std::size_t count = 0;
    for (const Piece& piece : pieces)
        count += piece.near_lit.size() + piece.near_unlit.size() + piece.far_unlit.size() +
                 piece.far_lit.size() + piece.unseen_lit.size();
    splats.all.reserve(count);
    splats.near_lit = append_all(&Piece::near_lit);
    splats.near = append_all(&Piece::near_unlit);
    splats.far_lit = append_all(&Piece::far_unlit);
    splats.seen = append_all(&Piece::far_lit);
    append_all(&Piece::unseen_lit);
    for (const Piece& piece : pieces) {
        append(splats.spray, piece.spray);
        splats.nearest = std::min(splats.nearest, piece.nearest);
    }
    return splats;
}

}  // namespace firn
