#pragma once
#include "render/egl_context.h"
#include "render/gl.h"
#include "render/meshes.h"
#include "render/relief.h"
#include "render/renderer.h"
#include "render/splats.h"
#include "render/view.h"

namespace firn {

/// What a quality costs.
struct Effort {
    int edge;            ///< samples along a pixel's edge.
    int shadow_size;     ///< [texels]
    int shadow_taps;     ///< samples of the shadow map for a sample of the picture.
    int smoothing_taps;  ///< neighbours to either side in the smoothing of depth.
};

Effort effort_of(Quality);

/// What a sample shows, as the stencil buffer holds it: each is smoothed and shaded by a shader of its own.
enum Kind : GLint { kind_sky, kind_snow, kind_ground, kind_body };

/// Everything of one picture that the passes share.
struct Frame {
    View view;
    ShadowView shadow;
    Eigen::Vector3f to_sun;
    std::vector<Plane> planes;
    float spacing;                               ///< [m]
    Eigen::Vector3f volume_origin, volume_size;  ///< [m]
    GLsizei splats, seen_splats;                 ///< in the buffer; so many of them, the first, can be seen.
    GLsizei vertices;                            ///< in the buffer
};

/// The passes of a picture, in the order in which they run, and the OpenGL objects that they keep.
struct Renderer::Passes {
    explicit Passes(const Picture&);
    Image draw(const ParticleView&, const std::vector<Collider>&, const Camera&, double time);

    Frame prepare(ParticleView, const std::vector<Collider>&, const Camera&, double time);
    void draw_shadows(const Frame&);
    void draw_surfaces(const Frame&);
    void smooth_depth(const Frame&);
    void shade(const Frame&);
    void resolve();
    Image read_back();

    void upload_volume(const Density&, float spacing, const Eigen::Vector3f& to_sun);
    void set_view(const Program&, const View&) const;

    EglContext context;  // first: it must outlive the rest
    Picture picture;
    Effort effort;
    int margin = 0;  ///< [samples]
    float max_point_size = 1;

    Buffer splats = make_buffer(), mesh = make_buffer();
    VertexArray splat_array = make_vertex_array(splats, {3, 1, 1}),
                mesh_array = make_vertex_array(mesh, {3, 3}), no_array = make_vertex_array(mesh, {});
    Texture relief = make_tile_texture(Relief::size, snow_relief().texels.data());
    Texture shadow_all, shadow_bodies, snow_outward = make_volume_texture(),
                                       snow_light = make_volume_texture();
    Texture depth_buffer, surface, depth, smoothed_once, smoothed_twice, light, developed;
    Framebuffer shadow_all_target, shadow_bodies_target, surface_target, smooth_once_target,
        smooth_twice_target, light_target, developed_target;
    Program shadow_mesh_program{{"shadow_mesh.vert"}, {"shadow_mesh.frag"}},
        shadow_splat_program{{"shadow_splat.vert"}, {"shadow_splat.frag"}},
        mesh_program{{"mesh.vert"}, {"mesh.frag"}}, plane_program{{"full_screen.vert"}, {"plane.frag"}},
        splat_program{{"splat.vert"}, {"splat.frag"}}, smooth_program{{"full_screen.vert"}, {"smooth.frag"}},
        sky_program{{"full_screen.vert"}, {"shade.glsl", "shade_sky.frag"}},
        snow_program{{"full_screen.vert"}, {"shade.glsl", "shade_snow.frag"}},
        ground_program{{"full_screen.vert"}, {"shade.glsl", "shade_ground.frag"}},
        body_program{{"full_screen.vert"}, {"shade.glsl", "shade_body.frag"}},
        resolve_program{{"full_screen.vert"}, {"resolve.frag"}};
};

}  // namespace firn
