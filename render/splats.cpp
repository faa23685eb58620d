#include "render/splats.h"

#include "render/hash.h"

#include <algorithm>
#include <array>
#include <atomic>
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
constexpr float whole_from = 0.27f;
float wholeness(float rho, float flying) { return smoothstep(0.05f + 0.10f * flying, whole_from, rho); }

/// The looser, the more unlike each other: few are large, and many fill the gaps.
float radius_of(float spacing, float whole, float hash) {
    const float h2 = hash * hash;
    return spacing * 0.85f * whole * std::lerp(0.5f + 1.75f * h2 * h2, 0.83f + 0.5f * h2, whole);
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

/// What particles in a cell are; `whole`: all in unbroken snow, none is spray.
enum Hidden : std::uint8_t { from_eye = 1, from_sun = 2, enclosed = 4, whole = 8, not_asked = 16 };

std::vector<std::uint8_t> enclosed_or_whole(const Field& rho, const Field& soft) {
    std::vector<std::uint8_t> cells = enclosed_cells(rho, solid);
    const std::vector<std::uint8_t> all_whole = enclosed_cells(soft, whole_from);
    const auto count = static_cast<std::ptrdiff_t>(cells.size());
#pragma omp parallel for
    for (std::ptrdiff_t c = 0; c < count; ++c)
        cells[c] = static_cast<std::uint8_t>(cells[c] ? enclosed : all_whole[c] ? whole : 0);
    return cells;
}

/// What snow hides the cells of a cover from, asked when the first particle in one is met. Whichever thread asks first,
/// the answer is the same.
struct HiddenCells {
    const Cover& cover;
    Vector3f eye, to_sun;
    std::vector<std::uint8_t> cells = std::vector<std::uint8_t>(cover.cells.size(), not_asked);

    int at(std::int32_t c) {
        const std::atomic_ref<std::uint8_t> known(cells[c]);
        std::uint8_t hidden = known.load(std::memory_order_relaxed);
        if (hidden == not_asked) known.store(hidden = asked(c), std::memory_order_relaxed);
        return hidden;
    }

    /// Particles are up to a cell's edge nearer than its middle.
    std::uint8_t asked(std::int32_t c) const {
        constexpr float from_cells = 1.7f;
        const int row = c / cover.size.x();
        const Eigen::Vector3i cell(c % cover.size.x(), row % cover.size.y(), row / cover.size.y());
        const Vector3f x = cover.origin + cover.cell * (cell.cast<float>() + Vector3f::Constant(0.5f));
        return static_cast<std::uint8_t>((is_covered(x, eye, cover, from_cells) ? from_eye : 0) |
                                         (cover.covers(x, to_sun, INFINITY, from_cells) ? from_sun : 0));
    }
};

/// Adds the hidden cells of a slice that touch one which is not: the plugs. Half a cell's diagonal is 0.87.
template <class Add>
void add_plugs(const Density& density, const std::vector<std::uint8_t>& cells, const Field& values, int k,
               Add add) {
    const Eigen::Vector3i size = density.rho.size;
    const auto inner = [&](int i, int j, int l) { return cells[density.rho.index(i, j, l)] == enclosed; };
    for (int j = 1; j < size.y() - 1; ++j)
        for (int i = 1; i < size.x() - 1; ++i) {
            if (!inner(i, j, k)) continue;
            const bool deep = inner(i - 1, j, k) && inner(i + 1, j, k) && inner(i, j - 1, k) &&
                              inner(i, j + 1, k) && inner(i, j, k - 1) && inner(i, j, k + 1);
            if (deep) continue;
            const Vector3f x = density.origin + density.cell * Vector3f(i + 0.5f, j + 0.5f, k + 0.5f);
            add(Splat{x.x(), x.y(), x.z(), 0.62f * density.cell, 0.5f,
                      values.values.empty() ? 0 : values.values[values.index(i, j, k)]});
        }
}

/// Calls f with each particle and the cell that it is in, or −1 outside.
template <class F>
void for_each_in_cells(const Density& density, const float* x, std::size_t first, std::size_t last, F f) {
    const Vector3f origin = density.origin, size = density.rho.size.cast<float>();
    const std::int32_t dy = density.rho.size.x(), dz = dy * density.rho.size.y();
    const float per_cell = 1 / density.cell;
    std::array<std::int32_t, 128> cell;
    for (std::size_t start = first; start < last; start += cell.size()) {
        const auto here = static_cast<std::ptrdiff_t>(std::min(cell.size(), last - start));
        const float* at = x + 3 * start;
        for (std::ptrdiff_t p = 0; p < here; ++p) {  // as many at once as the processor can
            const float u = (at[3 * p] - origin.x()) * per_cell, v = (at[3 * p + 1] - origin.y()) * per_cell,
                        w = (at[3 * p + 2] - origin.z()) * per_cell;
            const bool inside =
                (u >= 0) & (u < size.x()) & (v >= 0) & (v < size.y()) & (w >= 0) & (w < size.z());
            const int i = static_cast<int>(inside ? u : 0), j = static_cast<int>(inside ? v : 0),
                      k = static_cast<int>(inside ? w : 0);
            cell[p] = inside ? k * dz + j * dy + i : -1;
        }
        for (std::ptrdiff_t p = 0; p < here; ++p) f(start + p, cell[p]);
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

/// In a cloud of density ρ neighbours are ρ^(−1/3) apart: powder spreads as far, and where that is too far shows no more.
void spread_powder(SprayPoint& point, float spacing, float rho) {
    const float wider = std::clamp(std::cbrt(0.07f / std::max(rho, 1e-4f)), 1.0f, 2.2f);
    point.puff = 1.9f * spacing * wider;
    point.powder = point.amount / (wider * wider) * smoothstep(0.48f, 1, 1 / wider);
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
                     0,
                     0,
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
                      const Density& wide, const View& view, const Vector3f& to_sun, float near_radius,
                      const SplatDetail& detail) {
    const Field values = mean_values(particles, density);
    const Cover cover(density);
    HiddenCells hidden{cover, view.eye, to_sun};
    const std::vector<std::uint8_t> kinds = enclosed_or_whole(density.rho, soft.rho);

    const float wanted_per_metre = detail.radius * view.sample_tan / (0.85f * particles.spacing),
                wanted_to_throw = detail.thrower / (0.85f * particles.spacing);
    const auto kept_by = [](float hash) { return 64 * hash - std::floor(64 * hash); };
    const auto splat_of = [&](std::size_t p, float radius, float hash) {
        const float* at = &particles.x[3 * p];
        return Splat{at[0], at[1], at[2], radius, hash, particles.value.empty() ? 0 : particles.value[p]};
    };

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
            add_plugs(density, kinds, values, i - particle_pieces + 1, [&](const Splat& plug) {
                const Vector3f x(plug.x, plug.y, plug.z);
                add(plug, (is_covered(x, view.eye, cover) ? from_eye : 0) |
                              (cover.covers(x, to_sun, INFINITY) ? from_sun : 0));
            });
            continue;
        }
        const std::size_t first = i * piece_size, last = std::min(particles.size(), first + piece_size);
        for_each_in_cells(density, particles.x.data(), first, last, [&](std::size_t p, std::int32_t cell) {
            const int kind = cell < 0 ? 0 : kinds[cell];
            if (kind == enclosed) return;
            const int covered = cell < 0 ? 0 : hidden.at(cell);
            if (covered == (from_eye | from_sun)) return;
            const float* at = &particles.x[3 * p];
            if (!drawable(at)) return;
            const Vector3f x(at[0], at[1], at[2]);
            // A share of the particles, the same in every frame, covers as much [Cook et al. 2007].
            const float hash = hash_of(static_cast<std::uint32_t>(p)),
                        by_eye = wanted_per_metre * (x - view.eye).norm(),
                        wanted = std::max({1.0f, by_eye, covered & from_eye ? wanted_to_throw : 0.0f});
            const bool kept = kept_by(hash) * wanted * wanted <= 1;
            if (kind == whole) {
                if (kept) add(splat_of(p, radius_of(particles.spacing, 1, hash) * wanted, hash), covered);
                return;
            }
            const float rho = soft.at(x), flying = flight(particles, p), solid_share = wholeness(rho, flying);
            const float crumb = radius_of(particles.spacing, crumb_share(hash) * (1 - flying), hash);
            const bool sprayed = solid_share < crumb_share(hash) * (1 - flying) &&
                                 crumb < detail.crumb * view.sample_tan * view.basis.col(2).dot(x - view.eye);
            if (const float amount = (1 - solid_share) * (0.5f + 0.5f * flying); amount > 0.15f) {
                SprayPoint point = spray_point(particles, p, amount, 1 - smoothstep(0.03f, 0.10f, rho), hash);
                point.crumb = sprayed ? crumb : 0;
                // A grain that flies alone past a lump has none.
                spread_powder(point, particles.spacing, std::min(wide.at(x), 1.6f * (rho - 0.022f)));
                piece.spray.push_back(point);
            }
            if (const float radius =
                    std::max(radius_of(particles.spacing, std::sqrt(solid_share), hash), crumb);
                radius > 0.017f * particles.spacing && kept)
                add(splat_of(p, radius * wanted, hash), covered | (sprayed ? from_eye : 0));
        });
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
