#include "render/light.h"
#include "render/passes.h"
#include "sim/collision.h"

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace firn {

using Eigen::Vector3f;

namespace {

constexpr std::size_t max_cells = std::size_t(1) << 22;  ///< of the density grid: 70 MB of light and slope in them.

/// Positions, those in front of the plane replaced by none: a particle keeps its number.
std::vector<float> cut(std::span<const float> x, const Plane& plane) {
    std::vector<float> result(x.begin(), x.end());
    const Vector3f normal = plane.normal.cast<float>(), point = plane.point.cast<float>();
    for (std::size_t p = 0; p + 2 < x.size(); p += 3)
        if (normal.dot(Vector3f(x[p], x[p + 1], x[p + 2]) - point) > 0)
            std::fill_n(result.begin() + static_cast<std::ptrdiff_t>(p), 3, NAN);
    return result;
}

/// Corners of the grid's cells that hold particles, each once, in order [m].
std::vector<float> nodes_of(const ParticleView& particles) {
    std::vector<std::array<int, 3>> corners;
    if (!(particles.grid_spacing > 0)) return {};
    for (std::size_t p = 0; p < particles.size(); ++p) {
        if (!drawable(&particles.x[3 * p])) continue;
        std::array<int, 3> cell;
        for (int a = 0; a < 3; ++a)
            cell[a] = static_cast<int>(std::floor(particles.x[3 * p + a] / particles.grid_spacing));
        if (corners.empty() || corners.back() != cell) corners.push_back(cell);
    }
    const auto sort_out = [&] {
        std::sort(corners.begin(), corners.end());
        corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    };
    sort_out();
    for (int a = 0; a < 3; ++a) {
        const std::size_t count = corners.size();
        for (std::size_t c = 0; c < count; ++c) {
            auto next = corners[c];
            ++next[a];
            corners.push_back(next);
        }
        sort_out();
    }
    std::vector<float> nodes;
    for (const auto& corner : corners)
        for (const int i : corner) nodes.push_back(static_cast<float>(i) * particles.grid_spacing);
    return nodes;
}

Eigen::AlignedBox3f box_of(const std::vector<SolidGroup>& solids) {
    Eigen::AlignedBox3f all;
    for (const SolidGroup& group : solids)
        for (const Vertex& vertex : group.triangles) all.extend(vertex.position);
    return all;
}

/// Where fine shadows are wanted: around the snow, and around the bodies as far as they are near it.
Eigen::AlignedBox3f shadowed_region(const Density& density, Eigen::AlignedBox3f all, bool any_snow) {
    Eigen::AlignedBox3f snow;
    if (!any_snow)
        return all.isEmpty() ? Eigen::AlignedBox3f(Vector3f::Zero().eval(), Vector3f::Ones().eval()) : all;
    snow.extend(density.origin);
    snow.extend(density.origin + density.cell * density.rho.size.cast<float>());
    const Vector3f reach = Vector3f::Constant(snow.diagonal().norm());
    all = all.intersection(Eigen::AlignedBox3f(snow.min() - reach, snow.max() + reach));
    return all.isEmpty() ? snow : snow.merged(all);
}

}  // namespace

/// Four numbers of 16 bits in each.
static void upload_cells(const Texture& texture, const Eigen::Vector3i& n, const void* cells) {
    bind_texture(0, GL_TEXTURE_3D, texture);
    glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA16F, n.x(), n.y(), n.z(), 0, GL_RGBA, GL_HALF_FLOAT, cells);
    check_gl("light volume");
}

static VolumeCells volume_of(const Density& lit, const Density& soft, float spacing, const Vector3f& to_sun) {
    return {soft.rho.size, lit.rho.size, outward_of(soft.rho), light_in_snow(lit, spacing, to_sun)};
}

/// Density and what is to be drawn, on the CPU, and all of it to OpenGL; coarse light follows.
Frame Renderer::Passes::prepare(ParticleView particles, const std::vector<Solid>& solids,
                                const Camera& camera, double time) {
    if (particles.size() == 0 && !(particles.spacing > 0)) particles.spacing = 0.01f;
    if (!(particles.spacing > 0) || !std::isfinite(particles.spacing))
        throw std::invalid_argument("particles need a spacing greater than zero to be drawn");
    Frame frame;
    frame.view = view_of(camera, picture, effort.edge, margin, particles.spacing);
    frame.to_sun = sun_direction(picture);
    frame.light = sky_light_at(picture.sun_elevation);
    frame.spacing = particles.spacing;
    frame.coloured = picture.colour != Colour::snow && !particles.value.empty();
    frame.shutter = static_cast<float>(picture.shutter / std::max(picture.motion_samples, 1));
    frame.aperture = static_cast<float>(camera.aperture);
    frame.focus = static_cast<float>(
        std::max(camera.focus.value_or((camera.target - camera.eye).norm()), double(frame.view.near_depth)));

    std::vector<float> kept;
    if (picture.slice) {
        kept = cut(particles.x, *picture.slice);
        particles.x = kept;
    }
    if (picture.grid_nodes) frame.nodes = nodes_of(particles);

    const Density density = density_of(particles, max_cells);
    Density soft{density.origin, density.cell, smoothed(density.rho)}, half = halved(density);
    frame.volume_origin = density.origin;
    frame.volume_size = density.cell * density.rho.size.cast<float>();

    prepare_solids(frame, solids, time);
    const bool any_snow =
        std::any_of(density.rho.values.begin(), density.rho.values.end(), [](float rho) { return rho > 0; });
    const Eigen::AlignedBox3f bodies = box_of(frame.solids), region = shadowed_region(density, bodies, any_snow);
    const float radius = 0.5f * region.diagonal().norm();
    frame.shadow = shadow_view(frame.to_sun, region.center(), radius, effort.shadow_size);
    const Vector3f reach = Vector3f::Constant(20 * static_cast<float>((camera.target - camera.eye).norm()));
    const Vector3f target = camera.target.cast<float>();
    const Eigen::AlignedBox3f seen = bodies.intersection(Eigen::AlignedBox3f(target - reach, target + reach));
    if (!seen.isEmpty() && !region.contains(seen))
        frame.far_shadow =
            shadow_view(frame.to_sun, seen.center(), 0.5f * seen.diagonal().norm(), effort.shadow_size / 2);
    frame.bodies.reach = 0.3f * radius;

    const auto to_bodies = [&](const Vector3f& x) {
        double least = INFINITY;
        for (const Solid& solid : solids)
            least = std::min(least, signed_distance(solid, x.cast<double>(), time));
        return least;
    };
    Splats visible =
        visible_splats(particles, density, soft, halved(half), frame.view, frame.to_sun, effort.children_from,
                       to_bodies,
                       {effort.least_radius, effort.least_thrower * frame.shadow.texel,
                        std::max(1.2f * static_cast<float>(effort.edge), 1.0f)});
    if (!effort.fine_light)  // on one thread: software that draws leaves another idle while it sets points up
        frame.volume = std::async(std::launch::async, [half = std::move(half), soft = std::move(soft),
                                                       spacing = particles.spacing, to_sun = frame.to_sun] {
            omp_set_num_threads(1);
            return volume_of(half, soft, spacing, to_sun);
        });
    upload_snow(frame, visible);
    if (effort.fine_light) {  // one at a time: they are large
        visible = {};
        upload_cells(snow_outward, soft.rho.size, outward_of(soft.rho).data());
        soft = {};
        upload_cells(snow_light, density.rho.size,
                     light_in_snow(density, particles.spacing, frame.to_sun).data());
    }
    return frame;
}

void Renderer::Passes::upload_snow(Frame& frame, const Splats& visible) {
    upload(splats, visible.all.data(), visible.all.size() * sizeof(Splat));
    frame.splats = static_cast<GLsizei>(visible.all.size());
    frame.near_lit_splats = static_cast<GLsizei>(visible.near_lit);
    frame.near_splats = static_cast<GLsizei>(visible.near);
    frame.far_lit_splats = static_cast<GLsizei>(visible.far_lit);
    frame.seen_splats = static_cast<GLsizei>(visible.seen);
    frame.nearest_snow = std::max(visible.nearest, frame.view.near_depth);

    const SpraySorted sorted =
        sorted_spray(visible.spray, frame.view, frame.spacing, frame.shutter, effort.edge, effort.puffs);
    upload(spray, sorted.all.data(), sorted.all.size() * sizeof(SprayPoint));
    frame.spray = static_cast<GLsizei>(visible.spray.size());
    frame.spray_with_puffs = sorted.with_puffs;
    frame.spray_without = sorted.without;
    check_gl("upload");
}

void Renderer::Passes::upload_volume(const VolumeCells& volume) {
    upload_cells(snow_outward, volume.size, volume.outward.data());
    upload_cells(snow_light, volume.light_size, volume.light.data());
}

}  // namespace firn
