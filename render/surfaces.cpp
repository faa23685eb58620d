#include "render/passes.h"

#include <algorithm>
#include <cmath>

namespace firn {

using Eigen::Vector3f;

namespace {

/// Levels of the à-trous smoothing that a deviation [samples] takes.
int levels_for(double deviation) {
    int levels = 0;
    while (levels < 7 && (std::pow(4, levels) - 1) / 6 < deviation * deviation) ++levels;
    return levels;
}

}  // namespace

/// Depth and normal of what is nearest at every sample.
void Renderer::Passes::draw_surfaces(const Frame& frame) {
    glBindFramebuffer(GL_FRAMEBUFFER, surface_target.id());
    glViewport(0, 0, frame.view.samples.x(), frame.view.samples.y());
    const GLenum targets[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
    glDrawBuffers(frame.coloured ? 3 : 2, targets);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    glEnable(GL_STENCIL_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);

    for (std::size_t i = 0; i < frame.solids.size(); ++i) {
        const SolidGroup& group = frame.solids[i];
        glStencilFunc(GL_ALWAYS, kind_solid + static_cast<GLint>(i), 0xff);
        mesh_program.use();
        set_view(mesh_program, frame.view);
        glBindVertexArray(mesh_array.id());
        glDrawArrays(GL_TRIANGLES, group.first, static_cast<GLsizei>(group.triangles.size()));
        glBindVertexArray(no_array.id());
        for (const Plane& plane : group.planes) {
            plane_program.use();
            set_view(plane_program, frame.view);
            plane_program.set("plane_point", Vector3f(plane.point.cast<float>()));
            plane_program.set("plane_normal", Vector3f(plane.normal.cast<float>()));
            glDrawArrays(GL_TRIANGLES, 0, 3);
        }
    }
    check_gl("solids");

    glStencilFunc(GL_ALWAYS, kind_snow, 0xff);
    bind_texture(unit_relief, GL_TEXTURE_2D, relief);
    glBindSampler(unit_relief, quick_reader.id());
    glBindVertexArray(splat_array.id());
    const float children =
        std::min(effort.children, effort.all_children / static_cast<float>(std::max(frame.near_splats, 1)));
    for (const Program* program : {&near_splat_program, &splat_program}) {
        program->use();
        set_view(*program, frame.view);
        program->set("relief", unit_relief);
        program->set("children", children);
        program->set("edge", static_cast<float>(effort.edge));
        program->set("grown_from", effort.children_from);
        program->set("grown_to", 2 * effort.children_from);
        if (program == &splat_program)
            draw_many(GL_POINTS, frame.near_splats, frame.seen_splats - frame.near_splats);
        else
            draw_many(GL_POINTS, 0, frame.near_splats, 1 + static_cast<GLsizei>(std::ceil(children)));
    }
    glBindSampler(unit_relief, 0);
    glDisable(GL_DEPTH_TEST);
    glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    check_gl("splats");
}

/// First over a grain, then on over a lump.
void Renderer::Passes::smooth_depth(const Frame& frame) {
    smooth_program.use();
    set_view(smooth_program, frame.view);
    smooth_program.set("depths", unit_depths);
    glBindVertexArray(no_array.id());
    glStencilFunc(GL_EQUAL, kind_snow, 0xff);
    const float nearest_width = frame.nearest_snow * frame.view.sample_tan;
    const Texture* from = &depth;
    const auto smooth = [&](int first_level, float deviation, float range, int kept) {
        const int levels = std::max(levels_for(deviation / nearest_width), first_level + 1);
        for (int level = first_level; level < levels; ++level) {
            int to = 0;
            while (&smooth_depths[to] == from || to == kept) ++to;
            glBindFramebuffer(GL_FRAMEBUFFER, smooth_target[to].id());
            glClear(GL_COLOR_BUFFER_BIT);  // what is not snow is too far off to count
            bind_texture(unit_depths, GL_TEXTURE_2D, *from);
            smooth_program.set("stride", 1 << level);
            smooth_program.set("deviation", deviation);
            smooth_program.set("range", range);
            glDrawArrays(GL_TRIANGLES, 0, 3);
            from = &smooth_depths[to];
        }
        return levels;
    };
    const int levels = smooth(0, 1.2f * frame.spacing, 3.5f * frame.spacing, -1);
    fine = from;
    smooth(std::max(levels - 1, 1), 3.2f * frame.spacing, 6.0f * frame.spacing,
           static_cast<int>(fine - smooth_depths));
    wide = from;
    check_gl("smoothing");
}

}  // namespace firn
