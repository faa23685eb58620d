#include "render/passes.h"

#include <cmath>

namespace firn {

void Renderer::Passes::make_lens(const Eigen::Vector2i& samples) {
    lens_samples = {0, 0};
    blurred = make_texture_2d(GL_RGBA16F, samples.x(), samples.y());
    lens_target = make_framebuffer("light and depth (RGBA16F and R32F)", {&blurred, &smooth_depths[0]});
    blurred_target = make_framebuffer("light (RGBA16F, depth 24 stencil 8)", {&blurred}, &depth_buffer,
                                      GL_DEPTH_STENCIL_ATTACHMENT);
    for (int i = 0; i < 2; ++i) {
        lens_reach[i] = make_texture_2d(GL_R16F, blocks_of(samples.x()), blocks_of(samples.y()));
        lens_reach_target[i] = make_framebuffer("a lens's reach (R16F)", {&lens_reach[i]});
    }
    lens_samples = samples;
}

/// Depth of field: where discs may reach is found for blocks first, so that the taps lie no wider than they must. Leaves
/// the depth of what comes to each sample for the spray, which is drawn after it.
void Renderer::Passes::blur_by_lens(const Frame& frame, int moment) {
    if (lens_samples != frame.view.samples) make_lens(frame.view.samples);
    constexpr double widest_disc = 0.04;  // radius, of the picture's height: wider ones would show single taps
    const auto run = [&](const Program& program, const Framebuffer& target) {
        program.set("depths", unit_raw_depths);
        program.set("aperture", frame.aperture);
        program.set("focus", frame.focus);
        program.set("max_radius", static_cast<float>(widest_disc * picture.height * effort.edge));
        glBindFramebuffer(GL_FRAMEBUFFER, target.id());
        glDrawArrays(GL_TRIANGLES, 0, 3);
    };
    glBindVertexArray(no_array.id());
    glViewport(0, 0, blocks_of(frame.view.samples.x()), blocks_of(frame.view.samples.y()));
    lens_reach_program.use();
    set_view(lens_reach_program, frame.view);
    run(lens_reach_program, lens_reach_target[0]);
    lens_reach_around_program.use();
    set_view(lens_reach_around_program, frame.view);
    bind_texture(unit_depths, GL_TEXTURE_2D, lens_reach[0]);
    lens_reach_around_program.set("widest", unit_depths);
    run(lens_reach_around_program, lens_reach_target[1]);

    glViewport(0, 0, frame.view.samples.x(), frame.view.samples.y());
    lens_program.use();
    set_view(lens_program, frame.view);
    set_light(lens_program, frame);
    bind_texture(unit_depths, GL_TEXTURE_2D, light);
    bind_texture(unit_surface, GL_TEXTURE_2D, lens_reach[1]);
    lens_program.set("light", unit_depths);
    lens_program.set("reach", unit_surface);
    const double golden_ratio = 0.6180339887;  // its multiples are spread evenly
    lens_program.set("turn", static_cast<float>(std::fmod(0.5 + golden_ratio * moment, 1)));
    lens_program.set("edge", static_cast<float>(effort.edge));
    run(lens_program, lens_target);

    glBindFramebuffer(GL_FRAMEBUFFER, blurred_target.id());
    bind_texture(unit_raw_depths, GL_TEXTURE_2D, smooth_depths[0]);
    picture_light = &blurred;
    check_gl("lens");
}

}  // namespace firn
