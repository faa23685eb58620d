#include "render/splats.h"

#include "render/hash.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace firn {

namespace {

using Eigen::Vector3f;

Eigen::Vector3f cell_coordinates(const Vector3f& x, const Density& density) {
    return (x - density.origin) / density.cell;
}

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

/// Whether a ball may be in the picture.
bool in_picture(const Vector3f& x, float radius, const View& view) {
    const Vector3f p = view.basis.transpose() * (x - view.eye);
    const Eigen::Vector2f half = 0.5f * view.sample_tan * view.samples.cast<float>();
    return p.z() + radius > view.near_depth && std::abs(p.x()) < half.x() * (p.z() + radius) + 2 * radius &&
           std::abs(p.y()) < half.y() * (p.z() + radius) + 2 * radius;
}

/// What a piece of the particles gives.
struct Piece {
    std::vector<Splat> near_lit, near_unlit, far_unlit, far_lit, unseen_lit;
    std::vector<SprayPoint> spray;
    float nearest = INFINITY;
};

/// Particles that eye or sun may reach, and what is known of them: so many at once as the processor likes.
struct Batch {
    static constexpr std::size_t most = 128;
    std::size_t count = 0;
    std::array<std::uint32_t, most> p;
    std::array<std::uint8_t, most> kind;
    std::array<float, most> x, y, z, hash, wanted, rho;
};

/// Sorts particles and plugs into pieces; any number of threads may, each a piece of its own.
struct Chooser {
    const ParticleView& particles;
    const Density &density, &soft, &wide;
    const View& view;
    float near_radius;
    SplatDetail detail;
    HiddenCells& hidden;
    const DistanceToBodies& to_bodies;
    Field values;
    /// A lump in cells k times too wide seems 1/k³ as dense, a cloud seems as it is: between the two.
    float firm = std::pow(density.cell / (2 * particles.spacing), 1.5f);

    void add(Piece& piece, const Splat& splat, int covered) const {
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
    }

    /// Of up to Batch::most particles.
    Batch uncovered(std::size_t first, std::size_t count) const {
        const Vector3f origin = density.origin, size = density.rho.size.cast<float>();
        const std::int32_t dy = density.rho.size.x(), dz = dy * density.rho.size.y();
        const float per_cell = 1 / density.cell;
        const float* at = particles.x.data() + 3 * first;
        std::array<std::int32_t, Batch::most> cell;
        for (std::size_t p = 0; p < count; ++p) {  // as many at once as the processor can
            const float u = (at[3 * p] - origin.x()) * per_cell, v = (at[3 * p + 1] - origin.y()) * per_cell,
                        w = (at[3 * p + 2] - origin.z()) * per_cell;
            const bool inside =
                (u >= 0) & (u < size.x()) & (v >= 0) & (v < size.y()) & (w >= 0) & (w < size.z());
            const int i = static_cast<int>(inside ? u : 0), j = static_cast<int>(inside ? v : 0),
                      k = static_cast<int>(inside ? w : 0);
            cell[p] = inside ? k * dz + j * dy + i : -1;
        }
        std::array<std::uint8_t, Batch::most> known;
        for (std::size_t p = 0; p < count; ++p) known[p] = hidden.known(std::max(cell[p], 0));
        Batch batch;
        for (std::size_t p = 0; p < count; ++p) {
            int kind = known[p];
            if (cell[p] < 0) kind = drawable(at + 3 * p) ? 0 : enclosed;
            if ((kind & (not_asked | enclosed)) == not_asked) kind = hidden.ask(cell[p]);
            batch.p[batch.count] = static_cast<std::uint32_t>(first + p);
            batch.kind[batch.count] = static_cast<std::uint8_t>(kind);
            batch.count += !(kind & enclosed) & ((kind & (from_eye | from_sun)) != (from_eye | from_sun));
        }
        return batch;
    }

    /// `wanted`: of a share of 1/wanted² of the particles, the same in every frame, each is so much larger and all
    /// cover as much [Cook et al. 2007].
    void describe(Batch& batch) const {
        const float by_eye = detail.radius * view.sample_tan / (0.85f * particles.spacing),
                    to_throw = detail.thrower / (0.85f * particles.spacing);
        const Vector3f eye = view.eye;
        const float* x = particles.x.data();
        for (std::size_t i = 0; i < batch.count; ++i) {
            const std::size_t p = batch.p[i];
            batch.x[i] = x[3 * p], batch.y[i] = x[3 * p + 1], batch.z[i] = x[3 * p + 2];
        }
        for (std::size_t i = 0; i < batch.count; ++i) {
            const float a = batch.x[i] - eye.x(), b = batch.y[i] - eye.y(), c = batch.z[i] - eye.z();
            const float seen = std::max(1.0f, by_eye * std::sqrt(a * a + b * b + c * c));
            batch.wanted[i] = batch.kind[i] & from_eye ? std::max(seen, to_throw) : seen;
            batch.hash[i] = hash_of(batch.p[i]);
        }
        soft.at(batch.x.data(), batch.y.data(), batch.z.data(), batch.count, batch.rho.data());
        for (std::size_t i = 0; i < batch.count; ++i) batch.rho[i] *= firm;
    }

    void add_particles(Piece& piece, std::size_t first, std::size_t last) const {
        for (; first < last; first += Batch::most) {
            Batch batch = uncovered(first, std::min(Batch::most, last - first));
            describe(batch);
            for (std::size_t i = 0; i < batch.count; ++i) {
                const float kept = 64 * batch.hash[i] - std::floor(64 * batch.hash[i]);
                add_particle(piece, batch, i, kept * batch.wanted[i] * batch.wanted[i] <= 1);
            }
        }
    }

    /// A loose particle is a crumb, 0, or of a cloud, 1: where it moves on by its own size at once. What slides along a
    /// body must be faster, and what touches nothing flies even where it turns round.
    float flight(const Vector3f& x, std::size_t p, float rho) const {
        constexpr float at_once = 0.01f;  // [s]
        if (particles.v.empty() || !drawable(&particles.v[3 * p])) return 0;
        const Vector3f v(particles.v[3 * p], particles.v[3 * p + 1], particles.v[3 * p + 2]);
        const float way = v.norm() * at_once / particles.spacing,
                    away = smoothstep(2, 5, static_cast<float>(to_bodies(x)) / particles.spacing);
        return std::max(smoothstep(1.5f - 1.2f * away, 6 - 4.5f * away, way),
                        away * (1 - smoothstep(0.05f, 0.10f, rho)));
    }

    void add_particle(Piece& piece, const Batch& batch, std::size_t i, bool kept) const {
        const std::size_t p = batch.p[i];
        const float hash = batch.hash[i], rho = batch.rho[i], spacing = particles.spacing;
        const int covered = batch.kind[i] & (from_eye | from_sun);
        const auto splat_of = [&](float radius) {
            const float value = particles.value.empty() ? 0 : particles.value[p];
            return Splat{batch.x[i], batch.y[i], batch.z[i], radius * batch.wanted[i], hash, value};
        };
        if (batch.kind[i] & whole || rho >= whole_from) {
            if (kept) add(piece, splat_of(radius_of(spacing, 1, hash)), covered);
            return;
        }
        const Vector3f x(batch.x[i], batch.y[i], batch.z[i]);
        const float flying = flight(x, p, rho), solid_share = wholeness(rho, flying),
                    solid = radius_of(spacing, std::sqrt(solid_share), hash),
                    crumb = crumb_radius(spacing, flying, hash, hash_of(batch.p[i] + 0x9e3779b9u));
        const bool sprayed =
            solid < crumb && crumb < detail.crumb * view.sample_tan * view.basis.col(2).dot(x - view.eye);
        if (const float amount = (1 - 1.6f * solid_share) * (0.5f + 0.5f * flying); amount > 0.15f) {
            SprayPoint point = spray_point(particles, p, amount, 1 - smoothstep(0.03f, 0.10f, rho), hash,
                                           sprayed ? crumb : 0);
            // A grain that flies alone past a lump has none, and a lump in the open little.
            const float around = wide.at(x);
            spread_powder(point, spacing, std::min(around, 1.6f * (rho - lone_rho)));
            point.powder *= std::min(2 * around / std::max(rho, 1e-4f), 1.0f);
            piece.spray.push_back(point);
            if (sprayed && flying > 0.5f && point.powder > 0.01f) return;  // whose shade holds the crumb's
        }
        if (const float radius = std::max(solid, crumb); radius > 0.017f * spacing && kept)
            add(piece, splat_of(radius), covered | (sprayed ? from_eye : 0));
    }

    /// The hidden cells of a slice that touch one which is not. Half a cell's diagonal is 0.87.
    void add_plugs(Piece& piece, int k) const {
        const Eigen::Vector3i size = density.rho.size;
        const std::size_t dy = size.x(), dz = dy * size.y();
        for (int j = 1; j < size.y() - 1; ++j)
            for (int i = 1; i < size.x() - 1; ++i) {
                const std::size_t c = density.rho.index(i, j, k);
                if (!hidden.is_enclosed(c)) continue;
                bool deep = true;
                for (const std::size_t to : {std::size_t(1), dy, dz})
                    deep = deep && hidden.is_enclosed(c - to) && hidden.is_enclosed(c + to);
                if (deep) continue;
                const int covered = hidden.of_enclosed(i, j, k);
                if (covered == (from_eye | from_sun)) continue;
                const Vector3f x = density.origin + density.cell * Vector3f(i + 0.5f, j + 0.5f, k + 0.5f);
                add(piece,
                    {x.x(), x.y(), x.z(), 0.62f * density.cell, 0.5f,
                     values.values.empty() ? 0 : values.values[c]},
                    covered);
            }
    }
};

/// In order: the same splats for every number of threads.
Splats joined(const std::vector<Piece>& pieces) {
    Splats splats;
    std::size_t count = 0, spray = 0;
    for (const Piece& piece : pieces) {
        for (const auto part :
             {&piece.near_lit, &piece.near_unlit, &piece.far_unlit, &piece.far_lit, &piece.unseen_lit})
            count += part->size();
        spray += piece.spray.size();
        splats.nearest = std::min(splats.nearest, piece.nearest);
    }
    splats.all.reserve(count);
    splats.spray.reserve(spray);
    const auto append_all = [&](std::vector<Splat> Piece::*part) {
        for (const Piece& piece : pieces)
            splats.all.insert(splats.all.end(), (piece.*part).begin(), (piece.*part).end());
        return splats.all.size();
    };
    splats.near_lit = append_all(&Piece::near_lit);
    splats.near = append_all(&Piece::near_unlit);
    splats.far_lit = append_all(&Piece::far_unlit);
    splats.seen = append_all(&Piece::far_lit);
    append_all(&Piece::unseen_lit);
    for (const Piece& piece : pieces)
        splats.spray.insert(splats.spray.end(), piece.spray.begin(), piece.spray.end());
    return splats;
}

}  // namespace

Splats visible_splats(const ParticleView& particles, const Density& density, const Density& soft,
                      const Density& wide, const View& view, const Vector3f& to_sun, float near_radius,
                      const DistanceToBodies& to_bodies, const SplatDetail& detail) {
    const Cover cover(density);
    HiddenCells hidden(density, soft, cover, view.eye, to_sun);
    const Chooser chooser{particles,   density, soft,   wide,      view,
                          near_radius, detail,  hidden, to_bodies, mean_values(particles, density)};
    constexpr std::size_t piece_size = 16384;
    const auto of_particles = static_cast<int>((particles.size() + piece_size - 1) / piece_size);
    std::vector<Piece> pieces(of_particles + std::max(density.rho.size.z() - 2, 0));
#pragma omp parallel for schedule(dynamic)
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i) {
        if (i < of_particles)
            chooser.add_particles(pieces[i], i * piece_size,
                                  std::min(particles.size(), (i + 1) * piece_size));
        else
            chooser.add_plugs(pieces[i], i - of_particles + 1);
    }
    return joined(pieces);
}

}  // namespace firn
