#include "render/gl_limits.h"

#include "render/density.h"
#include "render/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>

namespace firn {

namespace {

int limit_of(GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

}  // namespace

GLLimits gl_limits() {
    GLint viewport[2] = {0, 0};
    GLfloat points[2] = {0, 0};
    glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    glGetFloatv(GL_POINT_SIZE_RANGE, points);
    GLLimits limits;
    limits.texture_size = std::min({limit_of(GL_MAX_TEXTURE_SIZE), viewport[0], viewport[1]});
    limits.texture_3d_size = limit_of(GL_MAX_3D_TEXTURE_SIZE);
    limits.texture_units = limit_of(GL_MAX_TEXTURE_IMAGE_UNITS);
    limits.vertex_texture_units = limit_of(GL_MAX_VERTEX_TEXTURE_IMAGE_UNITS);
    limits.combined_texture_units = limit_of(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS);
    limits.colour_attachments = std::min(limit_of(GL_MAX_COLOR_ATTACHMENTS), limit_of(GL_MAX_DRAW_BUFFERS));
    limits.dual_source_draw_buffers = limit_of(GL_MAX_DUAL_SOURCE_DRAW_BUFFERS);
    limits.vertex_uniforms = limit_of(GL_MAX_VERTEX_UNIFORM_COMPONENTS);
    limits.fragment_uniforms = limit_of(GL_MAX_FRAGMENT_UNIFORM_COMPONENTS);
    limits.varyings = limit_of(GL_MAX_VARYING_COMPONENTS);
    limits.vertex_attributes = limit_of(GL_MAX_VERTEX_ATTRIBS);
    limits.point_size = points[1];
    return limits;
}

std::string missing_in(const GLLimits& limits) {
    struct Need {
        const char* name;
        double there, needed;
        const char* purpose;
    };
    const Need needs[] = {
        {"GL_MAX_TEXTURE_SIZE or GL_MAX_VIEWPORT_DIMS", double(limits.texture_size), 2048, "the shadow map"},
        {"GL_MAX_3D_TEXTURE_SIZE", double(limits.texture_3d_size), longest_edge, "the light in snow"},
        {"GL_MAX_TEXTURE_IMAGE_UNITS", double(limits.texture_units), 14, "shading"},
        {"GL_MAX_VERTEX_TEXTURE_IMAGE_UNITS", double(limits.vertex_texture_units), 5, "spray"},
        {"GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS", double(limits.combined_texture_units), 15, "shading"},
        {"GL_MAX_COLOR_ATTACHMENTS or GL_MAX_DRAW_BUFFERS", double(limits.colour_attachments), 3, "surfaces"},
        {"GL_MAX_DUAL_SOURCE_DRAW_BUFFERS", double(limits.dual_source_draw_buffers), 1, "glass"},
        {"GL_MAX_VERTEX_UNIFORM_COMPONENTS", double(limits.vertex_uniforms), 256, "spray"},
        {"GL_MAX_FRAGMENT_UNIFORM_COMPONENTS", double(limits.fragment_uniforms), 512, "shading"},
        {"GL_MAX_VARYING_COMPONENTS", double(limits.varyings), 32, "spray"},
        {"GL_MAX_VERTEX_ATTRIBS", double(limits.vertex_attributes), 8, "spray"},
        {"GL_POINT_SIZE_RANGE", limits.point_size, 60, "splats that are near"},
    };
    std::string missing;
    for (const Need& need : needs)
        if (!(need.there >= need.needed))
            missing += "\n  " + std::string(need.name) + " is " + std::to_string(int(need.there)) + ", and " +
                       std::to_string(int(need.needed)) + " are needed for " + need.purpose;
    return missing;
}

GLLimits sufficient_limits(const std::string& opengl) {
    const GLLimits limits = gl_limits();
    if (const std::string missing = missing_in(limits); !missing.empty())
        throw GLError("this OpenGL (" + opengl + ") can do too little:" + missing);
    return limits;
}

}  // namespace firn
