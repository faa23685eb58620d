#include "render/renderer.h"

#include "render/light.h"
#include "render/passes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn {

using Eigen::Vector3f;

Effort effort_of(Quality quality) {
    switch (quality) {
        case Quality::draft:
            return {.edge = 1, .shadow_size = 1024, .shadow_taps = 4, .smoothing_taps = 4};
        case Quality::preview:
            return {.edge = 1, .shadow_size = 1024, .shadow_taps = 12, .smoothing_taps = 5};
        default:
            return {.edge = 2, .shadow_size = 2048, .shadow_taps = 12, .smoothing_taps = 5};
    }
}

namespace {

constexpr std::size_t max_cells = std::size_t(1) << 22;  ///< of the density grid: 100 MB of light in them.

/// Points spread over the unit disc: each turned on by the golden angle, the outermost first.
std::vector<Eigen::Vector2f> sunflower_disc() {
    constexpr int count = 12;
    std::vector<Eigen::Vector2f> disc;
    for (int i = count - 1; i >= 0; --i) {
        const double radius = std::sqrt((i + 0.5) / count),
                     angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
        disc.push_back(Eigen::Vector2d(radius * std::cos(angle), radius * std::sin(angle)).cast<float>());
    }
    return disc;
}

/// OpenGL would do the same, but slower.
std::vector<Eigen::half> halves(const float* first, std::size_t count) {
    std::vector<Eigen::half> result(count);
    for (std::size_t i = 0; i < count; ++i) result[i] = Eigen::half(first[i]);
    return result;
}

/// Where shadows are wanted: around the snow, and around the bodies as far as they are near it.
Eigen::AlignedBox3f shadowed_region(const Density& density, const std::vector<Vertex>& bodies,
                                    bool any_snow) {
    Eigen::AlignedBox3f snow, all;
    for (const Vertex& vertex : bodies) all.extend(vertex.position);
    if (!any_snow)
        return all.isEmpty() ? Eigen::AlignedBox3f(Vector3f::Zero().eval(), Vector3f::Ones().eval()) : all;
    snow.extend(density.origin);
    snow.extend(density.origin + density.cell * density.rho.size.cast<float>());
    const Vector3f reach = Vector3f::Constant(snow.diagonal().norm());
    all = all.intersection(Eigen::AlignedBox3f(snow.min() - reach, snow.max() + reach));
    return all.isEmpty() ? snow : snow.merged(all);
}

}  // namespace

Renderer::Renderer(const Picture& picture) : passes_(std::make_unique<Passes>(picture)) {}
Renderer::~Renderer() {
    if (passes_) passes_->context.make_current();
}
const std::string& Renderer::description() const { return passes_->context.description(); }

Image Renderer::draw(const ParticleView& particles, const std::vector<Collider>& colliders,
                     const Camera& camera, double time) {
    passes_->context.make_current();
    return passes_->draw(particles, colliders, camera, time);
}

Renderer::Passes::Passes(const Picture& wanted) : picture(wanted), effort(effort_of(wanted.quality)) {
    GLint texture_limit = 0, viewport_limit[2] = {0, 0};
    GLfloat point_range[2] = {1, 1};
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture_limit);
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport_limit);
    glGetFloatv(GL_POINT_SIZE_RANGE, point_range);
    max_point_size = point_range[1];

    const int limit = std::min({texture_limit, viewport_limit[0], viewport_limit[1]});
    const int largest = effort.edge * std::max(picture.width, picture.height);
    if (std::min(picture.width, picture.height) < 1 || largest > limit)
        throw GLError("a picture of " + std::to_string(picture.width) + "×" + std::to_string(picture.height) +
                      " pixels cannot be drawn: from 1 to " + std::to_string(limit / effort.edge) +
                      " pixels either way are possible at this quality");
    margin = std::min(16 * effort.edge, (limit - largest) / 2);
    const int width = effort.edge * picture.width + 2 * margin,
              height = effort.edge * picture.height + 2 * margin;

    shadow_all = make_shadow_texture(effort.shadow_size);
    shadow_bodies = make_shadow_texture(effort.shadow_size / 2);
    shadow_all_target = make_framebuffer({}, &shadow_all);
    shadow_bodies_target = make_framebuffer({}, &shadow_bodies);

    depth_buffer = make_depth_stencil_texture(width, height);
    depth = make_texture_2d(GL_R32F, width, height);
    surface = make_texture_2d(GL_RGB10_A2, width, height);
    surface_target = make_framebuffer({&depth, &surface}, &depth_buffer, GL_DEPTH_STENCIL_ATTACHMENT);
    smoothed_once = make_texture_2d(GL_R32F, width, height);
    smoothed_twice = make_texture_2d(GL_R32F, width, height);
    smooth_once_target = make_framebuffer({&smoothed_once}, &depth_buffer, GL_DEPTH_STENCIL_ATTACHMENT);
    smooth_twice_target = make_framebuffer({&smoothed_twice}, &depth_buffer, GL_DEPTH_STENCIL_ATTACHMENT);
    light = make_texture_2d(GL_RGBA16F, width, height);
    light_target = make_framebuffer({&light}, &depth_buffer, GL_DEPTH_STENCIL_ATTACHMENT);
    developed = make_texture_2d(GL_RGBA8, picture.width, picture.height);
    developed_target = make_framebuffer({&developed});
    check_gl("set-up");
}

Image Renderer::Passes::draw(const ParticleView& particles, const std::vector<Collider>& colliders,
                             const Camera& camera, double time) {
    const Frame frame = prepare(particles, colliders, camera, time);
    draw_shadows(frame);
    draw_surfaces(frame);
    smooth_depth(frame);
    shade(frame);
    resolve();
    return read_back();
}

/// Density, light volume and what is to be drawn, on the CPU; then all of it to OpenGL.
Frame Renderer::Passes::prepare(ParticleView particles, const std::vector<Collider>& colliders,
                                const Camera& camera, double time) {
    if (particles.size() == 0 && !(particles.spacing > 0)) particles.spacing = 0.01f;
    if (!(particles.spacing > 0) || !std::isfinite(particles.spacing))
        throw std::invalid_argument("particles need a spacing greater than zero to be drawn");
    Frame frame;
    frame.view = view_of(camera, picture, effort.edge, margin);
    frame.to_sun = sun_direction(picture);
    frame.spacing = particles.spacing;

    const Density density = density_of(particles, max_cells);
    frame.volume_origin = density.origin;
    frame.volume_size = density.cell * density.rho.size.cast<float>();
    upload_volume(density, particles.spacing, frame.to_sun);

    const Splats visible = visible_splats(particles, density, frame.view.eye);
    upload(splats, visible.all.data(), visible.all.size() * sizeof(Splat));
    frame.splats = static_cast<GLsizei>(visible.all.size());
    frame.seen_splats = static_cast<GLsizei>(visible.seen);

    std::vector<Vertex> triangles;
    for (const Collider& collider : colliders) {
        const std::vector<Vertex> mine = triangles_of(collider, time);
        triangles.insert(triangles.end(), mine.begin(), mine.end());
        if (const Plane* plane = std::get_if<Plane>(&collider.shape.kind()))
            frame.planes.push_back({plane->point + time * collider.velocity, plane->normal.normalized()});
    }
    upload(mesh, triangles.data(), triangles.size() * sizeof(Vertex));
    frame.vertices = static_cast<GLsizei>(triangles.size());

    const Eigen::AlignedBox3f region = shadowed_region(density, triangles, !visible.all.empty());
    frame.shadow =
        shadow_view(frame.to_sun, region.center(), 0.5f * region.diagonal().norm(), effort.shadow_size);
    check_gl("upload");
    return frame;
}

void Renderer::Passes::upload_volume(const Density& density, float spacing, const Vector3f& to_sun) {
    const std::vector<SnowLight> inside = light_in_snow(density, spacing, to_sun);
    const std::vector<Eigen::Vector4f> outward = outward_of(smoothed(density.rho));
    const Eigen::Vector3i n = density.rho.size;
    const auto upload_cells = [&](const Texture& texture, const float* first) {
        const std::vector<Eigen::half> cells = halves(first, 4 * density.rho.values.size());
        bind_texture(0, GL_TEXTURE_3D, texture);
        glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA16F, n.x(), n.y(), n.z(), 0, GL_RGBA, GL_HALF_FLOAT,
                     cells.data());
    };
    upload_cells(snow_outward, outward.data()->data());
    upload_cells(snow_light, inside.data()->sun);
    check_gl("light volume");
}

void Renderer::Passes::set_view(const Program& program, const View& view) const {
    program.set("eye", view.eye);
    program.set("basis", view.basis);
    program.set("samples", Eigen::Vector2f(view.samples.cast<float>()));
    program.set("sample_tan", view.sample_tan);
    program.set("near_depth", view.near_depth);
    program.set("projection", view.projection());
    program.set("max_point_size", max_point_size);
}

void Renderer::Passes::draw_shadows(const Frame& frame) {
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glEnable(GL_DEPTH_CLAMP);  // what stands between the sun and the region throws a shadow on it, too
    glEnable(GL_PROGRAM_POINT_SIZE);
    for (const bool all : {false, true}) {
        const int size = all ? effort.shadow_size : effort.shadow_size / 2;
        glBindFramebuffer(GL_FRAMEBUFFER, (all ? shadow_all_target : shadow_bodies_target).id());
        glViewport(0, 0, size, size);
        glClear(GL_DEPTH_BUFFER_BIT);
        shadow_mesh_program.use();
        shadow_mesh_program.set("shadow_matrix", frame.shadow.matrix);
        glBindVertexArray(mesh_array.id());
        glDrawArrays(GL_TRIANGLES, 0, frame.vertices);
        if (!all) continue;
        shadow_splat_program.use();
        shadow_splat_program.set("shadow_matrix", frame.shadow.matrix);
        shadow_splat_program.set("texel", frame.shadow.texel);
        shadow_splat_program.set("max_point_size", max_point_size);
        glBindVertexArray(splat_array.id());
        glDrawArrays(GL_POINTS, 0, frame.splats);
    }
    glDisable(GL_DEPTH_CLAMP);
    check_gl("shadows");
}

/// Depth and normal of what is nearest at every sample.
void Renderer::Passes::draw_surfaces(const Frame& frame) {
    glBindFramebuffer(GL_FRAMEBUFFER, surface_target.id());
    glViewport(0, 0, frame.view.samples.x(), frame.view.samples.y());
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    glEnable(GL_STENCIL_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);

    glStencilFunc(GL_ALWAYS, kind_body, 0xff);
    mesh_program.use();
    set_view(mesh_program, frame.view);
    glBindVertexArray(mesh_array.id());
    glDrawArrays(GL_TRIANGLES, 0, frame.vertices);
    check_gl("bodies");

    plane_program.use();
    set_view(plane_program, frame.view);
    glBindVertexArray(no_array.id());
    for (const Plane& plane : frame.planes) {
        glStencilFunc(GL_ALWAYS, plane.normal.y() > 0.5 ? kind_ground : kind_body, 0xff);
        plane_program.set("plane_point", Vector3f(plane.point.cast<float>()));
        plane_program.set("plane_normal", Vector3f(plane.normal.cast<float>()));
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    check_gl("planes");

    glStencilFunc(GL_ALWAYS, kind_snow, 0xff);
    splat_program.use();
    set_view(splat_program, frame.view);
    glBindVertexArray(splat_array.id());
    glDrawArrays(GL_POINTS, 0, frame.seen_splats);
    glDisable(GL_DEPTH_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    check_gl("splats");
}

void Renderer::Passes::smooth_depth(const Frame& frame) {
    smooth_program.use();
    set_view(smooth_program, frame.view);
    smooth_program.set("depths", 0);
    smooth_program.set("radius", 1.8f * frame.spacing);
    smooth_program.set("range", 2.0f * frame.spacing);
    smooth_program.set("max_taps", effort.smoothing_taps);
    glBindVertexArray(no_array.id());
    glStencilFunc(GL_EQUAL, kind_snow, 0xff);
    // Four directions: two alone would leave streaks along them.
    const Texture* from = &depth;
    for (const auto& [x, y] : {std::pair(1, 0), std::pair(1, 1), std::pair(0, 1), std::pair(-1, 1)}) {
        const bool once = from != &smoothed_once;
        glBindFramebuffer(GL_FRAMEBUFFER, (once ? smooth_once_target : smooth_twice_target).id());
        glClear(GL_COLOR_BUFFER_BIT);  // what is not snow is too far off to count
        bind_texture(0, GL_TEXTURE_2D, *from);
        smooth_program.set("along_x", x);
        smooth_program.set("along_y", y);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        from = once ? &smoothed_once : &smoothed_twice;
    }
    check_gl("smoothing");
}

void Renderer::Passes::shade(const Frame& frame) {
    glBindFramebuffer(GL_FRAMEBUFFER, light_target.id());
    bind_texture(1, GL_TEXTURE_2D, surface);
    bind_texture(2, GL_TEXTURE_2D, shadow_all);
    bind_texture(3, GL_TEXTURE_2D, shadow_bodies);
    bind_texture(4, GL_TEXTURE_3D, snow_outward);
    bind_texture(5, GL_TEXTURE_3D, snow_light);
    bind_texture(6, GL_TEXTURE_2D, relief);
    const char* const units[] = {"depths",       "surface",    "shadow_all", "shadow_bodies",
                                 "snow_outward", "snow_light", "relief"};
    const auto shade_kind = [&](Kind kind, const Program& program) {
        bind_texture(0, GL_TEXTURE_2D, kind == kind_snow ? smoothed_twice : depth);
        program.use();
        set_view(program, frame.view);
        for (int unit = 0; unit < 7; ++unit) program.set(units[unit], unit);
        program.set("volume_origin", frame.volume_origin);
        program.set("volume_size", frame.volume_size);
        program.set("shadow_matrix", frame.shadow.matrix);
        program.set("shadow_texel", frame.shadow.texel);
        program.set("shadow_taps", effort.shadow_taps);
        program.set("disc[0]", sunflower_disc());
        program.set("to_sun", frame.to_sun);
        program.set("spacing", frame.spacing);
        program.set("haze_distance", frame.view.haze_distance);
        program.set("exposure", static_cast<float>(picture.exposure));
        glStencilFunc(GL_EQUAL, kind, 0xff);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    };
    shade_kind(kind_sky, sky_program);
    shade_kind(kind_ground, ground_program);
    shade_kind(kind_body, body_program);
    shade_kind(kind_snow, snow_program);
    glDisable(GL_STENCIL_TEST);
    check_gl("shading");
}

void Renderer::Passes::resolve() {
    glBindFramebuffer(GL_FRAMEBUFFER, developed_target.id());
    glViewport(0, 0, picture.width, picture.height);
    resolve_program.use();
    resolve_program.set("light", 0);
    resolve_program.set("margin", margin);
    resolve_program.set("edge", effort.edge);
    bind_texture(0, GL_TEXTURE_2D, light);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    check_gl("resolve");
}

/// OpenGL's rows come from below.
Image Renderer::Passes::read_back() {
    const auto width = static_cast<std::size_t>(picture.width),
               height = static_cast<std::size_t>(picture.height);
    std::vector<std::uint8_t> rgba(4 * width * height);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, picture.width, picture.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    check_gl("read-back");
    Image image{picture.width, picture.height, std::vector<std::uint8_t>(3 * width * height)};
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            std::copy_n(&rgba[4 * ((height - 1 - y) * width + x)], 3, &image.pixels[3 * (y * width + x)]);
    return image;
}

}  // namespace firn
