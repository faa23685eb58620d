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

void Renderer::Passes::set_view(const Program& program, const View& view) const {
    program.set("eye", view.eye);
    program.set("basis", view.basis);
    program.set("samples", Eigen::Vector2f(view.samples.cast<float>()));
    program.set("sample_tan", view.sample_tan);
    program.set("near_depth", view.near_depth);
    program.set("projection", view.projection());
    program.set("max_point_size", max_point_size);
}

void Renderer::Passes::set_light(const Program& program, const Frame& frame) const {
    program.set("shadow_all", unit_shadow_all);
    program.set("shadow_depths", unit_shadow_depths);
    program.set("spray_shadow", unit_spray_shadow);
    program.set("shadow_bounds", unit_shadow_bounds);
    program.set("snow_light", unit_snow_light);
    program.set("volume_origin", frame.volume_origin);
    program.set("volume_size", frame.volume_size);
    program.set("shadow_matrix", frame.shadow.matrix);
    program.set("shadow_texel", frame.shadow.texel);
    program.set("shadow_span", frame.shadow.texel * static_cast<float>(effort.shadow_size));
    program.set("shadow_reach",
                frame.shadow.texel * static_cast<float>(effort.shadow_size / bounds_across));
    program.set("shadow_search", effort.shadow_search);
    program.set("shadow_taps", effort.shadow_taps);
    program.set("to_sun", frame.to_sun);
    program.set("sun_light", frame.light.sun);
    program.set("sky_light", frame.light.sky);
    program.set("sky_horizon", frame.light.horizon);
    program.set("sky_zenith", frame.light.zenith);
    program.set("spacing", frame.spacing);
    program.set("haze_distance", frame.view.haze_distance);
    program.set("exposure", static_cast<float>(picture.exposure));
}

void Renderer::Passes::set_bodies(const Program& program, const BodyDistances& bodies) const {
    program.set("body_a[0]", bodies.a);
    program.set("body_b[0]", bodies.b);
    program.set("body_reach", bodies.reach);
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
        glDrawArrays(GL_POINTS, 0, frame.near_lit_splats);
        glDrawArrays(GL_POINTS, frame.far_lit_splats, frame.splats - frame.far_lit_splats);
    }
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
    glDrawArrays(GL_POINTS, 0, frame.spray);
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
        plane_program.use();
        set_view(plane_program, frame.view);
        glBindVertexArray(no_array.id());
        for (const Plane& plane : group.planes) {
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
    for (const Program* program : {&near_splat_program, &splat_program}) {
        program->use();
        set_view(*program, frame.view);
        program->set("relief", unit_relief);
        program->set("grown_from", children_from);
        program->set("grown_to", 2.2f * children_from);
        if (program == &splat_program)
            glDrawArrays(GL_POINTS, frame.near_splats, frame.seen_splats - frame.near_splats);
        else if (frame.near_splats > 0)
            glDrawArraysInstanced(GL_POINTS, 0, frame.near_splats, 1 + effort.children);
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
    const int levels = smooth(0, 1.3f * frame.spacing, 2.6f * frame.spacing, -1);
    fine = from;
    smooth(std::max(levels - 1, 1), 3.2f * frame.spacing, 6.0f * frame.spacing,
           static_cast<int>(fine - smooth_depths));
    wide = from;
    check_gl("smoothing");
}

const Program& Renderer::Passes::shading_program(const std::string& name,
                                                 const std::vector<std::string>& files,
                                                 const BodyDistances& bodies) {
    const std::array<int, 4> counts = {bodies.boxes, bodies.capsules, bodies.cylinders, bodies.planes};
    const auto key = std::pair(name, counts);
    const auto made = shading_programs.find(key);
    if (made != shading_programs.end()) return made->second;
    return shading_programs
        .emplace(key, Program({"full_screen.vert"}, files,
                              {{"boxes", counts[0]},
                               {"capsules", counts[1]},
                               {"cylinders", counts[2]},
                               {"planes", counts[3]}}))
        .first->second;
}

const Program& Renderer::Passes::solid_program(Look look, const BodyDistances& bodies) {
    static const std::map<Look, std::string> names = {
        {Look::snow, "snow"},   {Look::ice, "ice"},           {Look::soil, "soil"},   {Look::wood, "wood"},
        {Look::tiles, "tiles"}, {Look::concrete, "concrete"}, {Look::metal, "metal"},
    };
    const std::string file = "look_" + names.at(look) + ".glsl";
    return shading_program(file, {"light.glsl", "bodies.glsl", "solid.glsl", file, "shade_solid.frag"},
                           bodies);
}

void Renderer::Passes::shade(const Frame& frame) {
    glBindFramebuffer(GL_FRAMEBUFFER, light_target.id());
    if (frame.aperture == 0) {  // the lens alone looks at what lies in the margin
        glEnable(GL_SCISSOR_TEST);
        glScissor(margin, margin, frame.view.samples.x() - 2 * margin, frame.view.samples.y() - 2 * margin);
    }
    bind_texture(unit_surface, GL_TEXTURE_2D, surface);
    bind_texture(unit_shadow_all, GL_TEXTURE_2D, shadow_all);
    bind_texture(unit_shadow_depths, GL_TEXTURE_2D, shadow_all);
    bind_texture(unit_shadow_bodies, GL_TEXTURE_2D, shadow_bodies);
    bind_texture(unit_spray_shadow, GL_TEXTURE_2D, spray_shadow);
    bind_texture(unit_snow_outward, GL_TEXTURE_3D, snow_outward);
    bind_texture(unit_snow_light, GL_TEXTURE_3D, snow_light);
    bind_texture(unit_wide_depths, GL_TEXTURE_2D, *wide);
    bind_texture(unit_raw_depths, GL_TEXTURE_2D, depth);
    bind_texture(unit_shadow_bounds, GL_TEXTURE_2D, shadow_bounds);
    bind_texture(unit_values, GL_TEXTURE_2D, values);
    bind_texture(unit_palette, GL_TEXTURE_2D, palette);
    const auto shade_kind = [&](GLint kind, const Program& program) {
        bind_texture(unit_depths, GL_TEXTURE_2D, kind == kind_snow ? *fine : depth);
        program.use();
        set_view(program, frame.view);
        set_light(program, frame);
        set_bodies(program, frame.bodies);
        program.set("depths", unit_depths);
        program.set("surface", unit_surface);
        program.set("shadow_bodies", unit_shadow_bodies);
        program.set("snow_outward", unit_snow_outward);
        program.set("wide_depths", unit_wide_depths);
        program.set("raw_depths", unit_raw_depths);
        program.set("relief", unit_relief);
        program.set("values", unit_values);
        program.set("palette", unit_palette);
        program.set("coloured", frame.coloured);
        glStencilFunc(GL_EQUAL, kind, 0xff);
    };
    shade_kind(kind_sky, sky_program);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glBindSampler(unit_relief, quick_reader.id());
    for (std::size_t i = 0; i < frame.solids.size(); ++i) {
        const Program& program = solid_program(frame.solids[i].look, frame.bodies);
        shade_kind(kind_solid + static_cast<GLint>(i), program);
        program.set("moved", frame.solids[i].moved);
        program.set("lie", frame.solids[i].lie);
        program.set("bend", frame.solids[i].bend);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glBindSampler(unit_relief, 0);
    check_gl("shading of solids");
    shade_kind(kind_snow,
               shading_program("snow", {"light.glsl", "bodies.glsl", "shade_snow.frag"}, frame.bodies));
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_STENCIL_TEST);
    check_gl("shading");
}

/// Over what is drawn, mirrored sky is added and what comes through weakened.
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
    glBindVertexArray(mesh_array.id());
    for (const GlassPlate& plate : frame.glass) {
        glass_program.set("max_depth_inside", plate.thickness);
        glDrawArrays(GL_TRIANGLES, plate.first, plate.count);
    }
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    glDepthMask(GL_TRUE);
    glDisable(GL_DEPTH_TEST);
    check_gl("glass");
}

/// Thin and all of nearly one colour: its order is not worth sorting.
void Renderer::Passes::draw_spray(const Frame& frame) {
    if (frame.spray == 0) return;
    glEnable(GL_DEPTH_TEST);
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
        program->set("shutter", frame.shutter);
        program->set("edge", static_cast<float>(effort.edge));
        const auto draw = [&](GLenum what, std::size_t first, std::size_t end, int each) {
            if (end > first) glDrawArraysInstanced(what, static_cast<GLint>(first), static_cast<GLsizei>(end - first), each);
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

void Renderer::Passes::blur_by_lens(const Frame& frame) {
    glBindFramebuffer(GL_FRAMEBUFFER, blurred_target.id());
    lens_program.use();
    set_view(lens_program, frame.view);
    bind_texture(unit_depths, GL_TEXTURE_2D, light);
    lens_program.set("light", unit_depths);
    lens_program.set("depths", unit_raw_depths);
    lens_program.set("aperture", frame.aperture);
    lens_program.set("focus", frame.focus);
    lens_program.set("max_radius", static_cast<float>(0.02 * picture.height * effort.edge));
    glBindVertexArray(no_array.id());
    glDrawArrays(GL_TRIANGLES, 0, 3);
    picture_light = &blurred;
    check_gl("lens");
}

}  // namespace firn
