#include "render/passes.h"

namespace firn {

/// Over what is drawn, mirrored country is added and what comes through weakened.
void Renderer::Passes::draw_glass(const Frame& frame) {
    if (frame.glass.empty()) return;
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glEnable(GL_CULL_FACE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_SRC1_COLOR);
    glass_program.use();
    set_view(glass_program, frame.view);
    set_light(glass_program, frame);
    glass_program.set("relief", unit_relief);
    glBindVertexArray(mesh_array.id());
    for (const GlassPlate& plate : frame.glass) {
        glass_program.set("max_depth_inside", plate.thickness);
        glDrawArrays(GL_TRIANGLES, plate.first, plate.count);
    }
    glDisable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ZERO);  // two sources would keep the lens from drawing into two textures
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
    check_gl("glass");
}

/// Thin and all of nearly one colour: its order is not worth sorting.
void Renderer::Passes::draw_spray(const Frame& frame) {
    if (frame.spray == 0) return;
    if (frame.aperture == 0) glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_FALSE);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    for (const Program* program : {&puff_program, &grain_program, &streak_program}) {
        if (program == &streak_program && frame.shutter == 0) continue;
        program->use();
        set_view(*program, frame.view);
        set_light(*program, frame);
        program->set("raw_depths", unit_raw_depths);
        program->set("snow_outward", unit_snow_outward);
        program->set("puff_share", effort.puffs);
        program->set("palette", unit_palette);
        program->set("coloured", frame.coloured);
        program->set("undeveloped", false);  // it is drawn after the lens
        program->set("shutter", frame.shutter);
        program->set("aperture", frame.aperture);
        program->set("focus", frame.focus);
        program->set("edge", static_cast<float>(effort.edge));
        const auto draw = [&](GLenum what, std::size_t first, std::size_t end, int each) {
            draw_many(what, static_cast<GLint>(first), static_cast<GLsizei>(end - first), each);
        };
        const SpraySorted::Part &with = frame.spray_with_puffs, &without = frame.spray_without;
        if (program == &puff_program) {
            glBindVertexArray(spray_array.id());
            draw(GL_POINTS, with.first, with.end, 1);
        } else if (program == &grain_program) {
            draw(GL_POINTS, with.first, with.points_end, 1 + effort.grains);
            draw(GL_POINTS, without.first, without.points_end, 1 + effort.grains);
        } else {
            glBindVertexArray(spray_line_array.id());
            draw(GL_LINES, 2 * with.lines, 2 * with.end, effort.grains);
            draw(GL_LINES, 2 * without.lines, 2 * without.end, effort.grains);
        }
    }
    glDisable(GL_BLEND);
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
    check_gl("spray");
}

void Renderer::Passes::draw_nodes(const Frame& frame) {
    if (frame.nodes.empty()) return;
    glEnable(GL_DEPTH_TEST);
    node_program.use();
    set_view(node_program, frame.view);
    node_program.set("edge", static_cast<float>(effort.edge));
    upload(nodes, frame.nodes.data(), frame.nodes.size() * sizeof(float));
    glBindVertexArray(node_array.id());
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(frame.nodes.size() / 3));
    glDisable(GL_DEPTH_TEST);
    check_gl("nodes");
}

}  // namespace firn
