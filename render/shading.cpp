#include "render/passes.h"

namespace firn {

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
                               {"planes", counts[3]},
                               {"max_bodies", max_bodies}}))
        .first->second;
}

const Program& Renderer::Passes::solid_program(Look look, const BodyDistances& bodies) {
    static const std::map<Look, std::string> names = {
        {Look::snow, "snow"},   {Look::ice, "ice"},           {Look::soil, "soil"},   {Look::wood, "wood"},
        {Look::tiles, "tiles"}, {Look::concrete, "concrete"}, {Look::metal, "metal"},
    };
    const std::string file = "look_" + names.at(look) + ".glsl";
    return shading_program(
        file,
        {"light.glsl", "country.glsl", "bodies.glsl", "glint.glsl", "solid.glsl", file, "shade_solid.frag"},
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
    bind_texture(unit_shadow_far, GL_TEXTURE_2D, shadow_far);
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
        program.set("snow_outward", unit_snow_outward);
        program.set("wide_depths", unit_wide_depths);
        program.set("raw_depths", unit_raw_depths);
        program.set("relief", unit_relief);
        program.set("values", unit_values);
        program.set("palette", unit_palette);
        program.set("coloured", frame.coloured);
        program.set("edge", static_cast<float>(effort.edge));
        program.set("aperture", frame.aperture);
        program.set("snow_ground", frame.snow_ground);
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
        program.set("axis", frame.solids[i].axis);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glBindSampler(unit_relief, 0);
    check_gl("shading of solids");
    shade_kind(kind_snow,
               shading_program("snow", {"light.glsl", "bodies.glsl", "glint.glsl", "shade_snow.frag"}, frame.bodies));
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_STENCIL_TEST);
    check_gl("shading");
}

}  // namespace firn
