#include "render/passes.h"

namespace firn {

void Renderer::Passes::draw_shadows(const Frame& frame) {
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glEnable(GL_DEPTH_CLAMP);  // what stands between the sun and the region throws a shadow on it, too
    glEnable(GL_PROGRAM_POINT_SIZE);
    shadow_mesh_program.use();
    const auto draw_bodies = [&](const Framebuffer& target, int size, const ShadowView& view) {
        glBindFramebuffer(GL_FRAMEBUFFER, target.id());
        glViewport(0, 0, size, size);
        glClear(GL_DEPTH_BUFFER_BIT);
        shadow_mesh_program.set("shadow_matrix", view.matrix);
        glBindVertexArray(mesh_array.id());
        glDrawArrays(GL_TRIANGLES, 0, frame.vertices);
    };
    if (frame.far_shadow) draw_bodies(shadow_far_target, effort.shadow_size / 2, *frame.far_shadow);
    draw_bodies(shadow_bodies_target, effort.shadow_size / 2, frame.shadow);
    draw_bodies(shadow_all_target, effort.shadow_size, frame.shadow);
    shadow_splat_program.use();
    shadow_splat_program.set("shadow_matrix", frame.shadow.matrix);
    shadow_splat_program.set("texel", frame.shadow.texel);
    shadow_splat_program.set("max_point_size", max_point_size);
    glBindVertexArray(splat_array.id());
    draw_many(GL_POINTS, 0, frame.near_lit_splats);
    draw_many(GL_POINTS, frame.far_lit_splats, frame.splats - frame.far_lit_splats);
    // Spray between the sun and the first body, its optical depths added up.
    glBindFramebuffer(GL_FRAMEBUFFER, spray_shadow_target.id());
    glViewport(0, 0, effort.shadow_size / 2, effort.shadow_size / 2);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    shadow_spray_program.use();
    shadow_spray_program.set("shadow_matrix", frame.shadow.matrix);
    shadow_spray_program.set("texel", 2 * frame.shadow.texel);
    shadow_spray_program.set("max_point_size", max_point_size);
    glBindVertexArray(spray_array.id());
    draw_many(GL_POINTS, 0, frame.spray);
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_CLAMP);
    check_gl("shadows");
    bound_shadows();
    check_gl("bounds of shadows");
}

/// Most of the picture is far from any shade or deep in it: what the map holds nearby tells where.
void Renderer::Passes::bound_shadows() {
    glDisable(GL_DEPTH_TEST);
    glBindVertexArray(no_array.id());
    shadow_blocks_program.use();
    shadow_blocks_program.set("shadow_depths", unit_shadow_depths);
    shadow_blocks_program.set("spray_shadow", unit_spray_shadow);
    shadow_blocks_program.set("blocks_across", blocks_across);
    bind_texture(unit_shadow_depths, GL_TEXTURE_2D, shadow_all);
    bind_texture(unit_spray_shadow, GL_TEXTURE_2D, spray_shadow);
    glBindFramebuffer(GL_FRAMEBUFFER, shadow_blocks_target[0].id());
    glViewport(0, 0, blocks_across, blocks_across);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    shadow_bounds_program.use();
    shadow_bounds_program.set("blocks", unit_shadow_bounds);
    glViewport(0, 0, bounds_across, bounds_across);
    const auto draw = [&](const Texture& from, const Framebuffer& to, int edge, int reach) {
        bind_texture(unit_shadow_bounds, GL_TEXTURE_2D, from);
        shadow_bounds_program.set("edge", edge);
        shadow_bounds_program.set("reach", reach);
        shadow_bounds_program.set("last_step", to.id() == shadow_bounds_target.id());
        glBindFramebuffer(GL_FRAMEBUFFER, to.id());
        glDrawArrays(GL_TRIANGLES, 0, 3);
    };
    draw(shadow_blocks[0], shadow_blocks_target[1], blocks_across / bounds_across, 0);
    draw(shadow_blocks[1], shadow_bounds_target, 1, 1);
    glEnable(GL_DEPTH_TEST);
}

}  // namespace firn
