#include "render/renderer.h"

#include "render/colour_map.h"
#include "render/enlarged.h"
#include "render/passes.h"

#include <algorithm>

namespace firn {

namespace {

Texture make_palette(Colour colour) {
    constexpr int size = 256;
    std::vector<std::uint8_t> texels;
    for (int i = 0; i < size; ++i) {
        const auto c = mapped_colour(colour, i / (size - 1.0));
        texels.insert(texels.end(), {c[0], c[1], c[2], 255});
    }
    return make_strip_texture(size, texels.data());
}

}  // namespace

Renderer::Renderer(const Picture& picture) : passes_(std::make_unique<Passes>(picture)) {}
Renderer::~Renderer() {
    if (passes_) passes_->context.make_current();
}
const std::string& Renderer::description() const { return passes_->context.description(); }

Image Renderer::draw(const ParticleView& particles, const std::vector<Solid>& solids, const Camera& camera,
                     double time) {
    passes_->context.make_current();
    return passes_->draw(particles, solids, camera, time);
}

Renderer::Passes::Passes(const Picture& wanted) : picture(wanted), effort(effort_of(wanted.quality)) {
    const int limit = limits.texture_size;
    const Eigen::Vector2i inner = samples_of(picture, effort.edge, 0);
    const int largest = std::max({inner.x(), inner.y(), picture.width, picture.height});
    if (std::min(picture.width, picture.height) < 1 || largest > limit)
        throw GLError("a picture of " + std::to_string(picture.width) + "×" + std::to_string(picture.height) +
                      " pixels cannot be drawn: from 1 to " +
                      std::to_string(static_cast<int>(limit / std::max(effort.edge, 1.0))) +
                      " pixels either way are possible at this quality");
    margin = std::min(static_cast<int>(16 * effort.edge), (limit - largest) / 2);
    const int width = inner.x() + 2 * margin, height = inner.y() + 2 * margin;

    shadow_all = make_shadow_texture(effort.shadow_size);
    shadow_bodies = make_shadow_texture(effort.shadow_size / 2);
    shadow_far = make_shadow_texture(effort.shadow_size / 2);
    spray_shadow = make_texture_2d(GL_R16F, effort.shadow_size / 2, effort.shadow_size / 2, GL_LINEAR);
    spray_shadow_target =
        make_framebuffer("the shadow of spray (R16F, depth 32F)", {&spray_shadow}, &shadow_bodies);
    for (int i = 0; i < 2; ++i) {
        shadow_blocks[i] =
            make_texture_2d(GL_RGBA32F, i ? bounds_across : blocks_across, i ? bounds_across : blocks_across);
        shadow_blocks_target[i] = make_framebuffer("bounds of the shadow map (RGBA32F)", {&shadow_blocks[i]});
    }
    shadow_bounds = make_texture_2d(GL_RGB10_A2, bounds_across, bounds_across);
    shadow_bounds_target = make_framebuffer("bounds of the shadow map (RGB10_A2)", {&shadow_bounds});
    shadow_all_target = make_framebuffer("a shadow map (depth 32F)", {}, &shadow_all);
    shadow_bodies_target = make_framebuffer("a shadow map (depth 32F)", {}, &shadow_bodies);
    shadow_far_target = make_framebuffer("a shadow map (depth 32F)", {}, &shadow_far);

    depth_buffer = make_depth_stencil_texture(width, height);
    depth = make_texture_2d(GL_R32F, width, height);
    surface = make_texture_2d(GL_RGB10_A2, width, height);
    if (picture.colour == Colour::snow) {
        surface_target = make_framebuffer("surfaces (R32F and RGB10_A2, depth 24 stencil 8)",
                                          {&depth, &surface}, &depth_buffer, GL_DEPTH_STENCIL_ATTACHMENT);
    } else {
        palette = make_palette(picture.colour);
        values = make_texture_2d(GL_R16F, width, height);
        surface_target =
            make_framebuffer("surfaces (R32F, RGB10_A2 and R16F, depth 24 stencil 8)",
                             {&depth, &surface, &values}, &depth_buffer, GL_DEPTH_STENCIL_ATTACHMENT);
    }
    for (int i = 0; i < 3; ++i) {
        smooth_depths[i] = make_texture_2d(GL_R32F, width, height);
        smooth_target[i] = make_framebuffer("depth (R32F, depth 24 stencil 8)", {&smooth_depths[i]},
                                            &depth_buffer, GL_DEPTH_STENCIL_ATTACHMENT);
    }
    light = make_texture_2d(GL_RGBA16F, width, height);
    light_target = make_framebuffer("light (RGBA16F, depth 24 stencil 8)", {&light}, &depth_buffer,
                                    GL_DEPTH_STENCIL_ATTACHMENT);
    make_lens({1, 1});  // shows that it can be made
    developed_size = effort.edge < 1 ? inner : Eigen::Vector2i(picture.width, picture.height);
    film = make_texture_2d(GL_RGBA16F, developed_size.x(), developed_size.y());
    film_target = make_framebuffer("film (RGBA16F)", {&film});
    developed = make_texture_2d(GL_RGBA8, developed_size.x(), developed_size.y());
    developed_target = make_framebuffer("a picture (RGBA8)", {&developed});
    check_gl("set-up");
}

/// Moments are spread evenly over the time that the shutter is open, half of it before `time`.
Image Renderer::Passes::draw(const ParticleView& particles, const std::vector<Solid>& solids,
                             const Camera& camera, double time) {
    const int count = particles.v.empty() && camera.keyframes.empty() && camera.orbit == 0
                          ? 1
                          : std::max(picture.motion_samples, 1);
    std::vector<float> moved;
    for (int i = 0; i < count; ++i) {
        const double later = picture.shutter * ((i + 0.5) / count - 0.5);
        ParticleView now = particles;
        if (count > 1 && !particles.v.empty()) {
            moved.assign(particles.x.begin(), particles.x.end());
            for (std::size_t c = 0; c < moved.size(); ++c)
                moved[c] += static_cast<float>(later) * particles.v[c];
            now.x = moved;
        }
        draw_moment(now, solids, camera_at(camera, time + later), time + later, i);
        expose(count, i == 0);
    }
    develop();
    return read_back();
}

void Renderer::Passes::draw_moment(const ParticleView& particles, const std::vector<Solid>& solids,
                                   const Camera& camera, double time, int moment) {
    Frame frame = prepare(particles, solids, camera, time);
    draw_shadows(frame);
    if (frame.volume.valid()) upload_volume(frame.volume.get());
    draw_surfaces(frame);
    smooth_depth(frame);
    shade(frame);
    draw_nodes(frame);
    draw_glass(frame);
    picture_light = &light;
    if (frame.aperture > 0) blur_by_lens(frame, moment);
    draw_spray(frame);  // which is blurred grain by grain: a pixel of it has no depth of its own
    glDisable(GL_SCISSOR_TEST);
}

/// From samples to pixels; moments add up.
void Renderer::Passes::expose(int moments, bool first) {
    glBindFramebuffer(GL_FRAMEBUFFER, film_target.id());
    glViewport(0, 0, developed_size.x(), developed_size.y());
    if (first) glClear(GL_COLOR_BUFFER_BIT);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    expose_program.use();
    expose_program.set("light", 0);
    expose_program.set("margin", margin);
    expose_program.set("share", 1.0f / static_cast<float>(moments));
    bind_texture(0, GL_TEXTURE_2D, *picture_light);
    glBindVertexArray(no_array.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_BLEND);
    check_gl("exposure");
}

void Renderer::Passes::develop() {
    glBindFramebuffer(GL_FRAMEBUFFER, developed_target.id());
    develop_program.use();
    develop_program.set("film", 0);
    bind_texture(0, GL_TEXTURE_2D, film);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    check_gl("development");
}

/// OpenGL's rows come from below.
Image Renderer::Passes::read_back() {
    const auto width = static_cast<std::size_t>(developed_size.x()),
               height = static_cast<std::size_t>(developed_size.y());
    std::vector<std::uint8_t> rgba(4 * width * height);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, developed_size.x(), developed_size.y(), GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
    check_gl("read-back");
    Image image{developed_size.x(), developed_size.y(), std::vector<std::uint8_t>(3 * width * height)};
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            std::copy_n(&rgba[4 * ((height - 1 - y) * width + x)], 3, &image.pixels[3 * (y * width + x)]);
    return effort.edge < 1 ? enlarged(image, picture.width, picture.height, effort.edge) : image;
}

}  // namespace firn
