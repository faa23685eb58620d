#pragma once
#include <string>

namespace firn {

/// What an OpenGL 3.3 can do at most; GL_MAX_… of the same name.
struct GLLimits {
    int texture_size = 0;     ///< [texels], the smaller of that and the viewport's.
    int texture_3d_size = 0;  ///< [texels]
    int texture_units = 0, vertex_texture_units = 0, combined_texture_units = 0;
    int colour_attachments = 0, dual_source_draw_buffers = 0;
    int vertex_uniforms = 0, fragment_uniforms = 0;  ///< [components]
    int varyings = 0;                                ///< [components]
    int vertex_attributes = 0;
    float point_size = 0;  ///< [samples]
};

/// Of the context that is current.
GLLimits gl_limits();

/// What the renderer needs and these limits lack, a line for each: "GL_MAX_… is 1, and 3 are needed for …". Empty
/// where nothing is missing. The size of the picture is not in it.
std::string missing_in(const GLLimits&);

/// Of the context that is current, which is called so. Throws GLError by the names of what is missing.
GLLimits sufficient_limits(const std::string& opengl);

}  // namespace firn
