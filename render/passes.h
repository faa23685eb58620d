#pragma once
#include "render/effort.h"
#include "render/egl_context.h"
#include "render/gl_limits.h"
#include "render/light.h"
#include "render/meshes.h"
#include "render/program.h"
#include "render/relief.h"
#include "render/renderer.h"
#include "render/sky.h"
#include "render/spray.h"
#include "render/view.h"

#include <array>
#include <future>
#include <map>
#include <optional>

namespace firn {

/// Blocks of the shadow map whose depths are known in bounds, along an edge: first, and then with those around.
inline constexpr int blocks_across = 256, bounds_across = 64;

/// Of so many samples along an edge, the blocks that are searched for a lens's discs as one (shaders/lens.glsl).
constexpr int blocks_of(int samples) { return (samples + 15) / 16; }

/// What a sample shows, as the stencil buffer holds it: each is shaded on its own. Solids come after these.
enum Kind : GLint { kind_sky, kind_snow, kind_solid };

/// Colliders of one look that have moved equally far.
struct SolidGroup {
    Look look;
    Eigen::Vector3f moved;           ///< since the start [m]
    Eigen::Matrix3f lie;             ///< columns along the body, up, and across: its pattern runs along.
    Eigen::Vector4f axis;            ///< a point on it at the start, radius; 0 if flat [m]: the pattern goes around.
    std::vector<Plane> planes;
    std::vector<Vertex> triangles;
    GLint first = 0;                 ///< in the buffer
};

struct GlassPlate {
    GLint first;
    GLsizei count;
    float thickness;                 ///< [m]
};

/// That hide the sky and are mirrored: a scene's first.
inline constexpr int max_bodies = 16;

/// Distances to bodies, as shaders/bodies.glsl wants them.
struct BodyDistances {
    std::vector<Eigen::Vector4f> a, b, colour;
    int boxes = 0, capsules = 0, cylinders = 0, planes = 0;  ///< in this order
    float reach;                     ///< over which they hide the sky [m]
};

/// Light and slope of the density, as textures take them.
struct VolumeCells {
    Eigen::Vector3i size, light_size;
    std::vector<Eigen::half> outward;
    std::vector<SnowLight> light;
};

/// Everything of one picture that the passes share.
struct Frame {
    View view;
    ShadowView shadow;                           ///< of the snow and the bodies about it,
    std::optional<ShadowView> far_shadow;        ///< and of all bodies, if some are farther off.
    Eigen::Vector3f to_sun;
    SkyLight light;
    Eigen::Vector4f snow_ground;                 ///< n and -n·p of a ground of snow; of none, all is far over it.
    Eigen::Vector3f ground;                      ///< light that comes back from it, as a share of what snow returns.
    std::vector<SolidGroup> solids;
    std::vector<GlassPlate> glass;
    std::vector<float> nodes;                    ///< of the grid, 3 each [m].
    bool coloured;
    float shutter;                               ///< how long it is open in this moment [s].
    float focus, aperture;                       ///< [m]
    BodyDistances bodies;
    float spacing;                               ///< [m]
    float nearest_snow;                          ///< depth [m]
    Eigen::Vector3f volume_origin, volume_size;  ///< [m]
    std::future<VolumeCells> volume;             ///< made while shadows are drawn; none if it is uploaded.
    GLsizei near_lit_splats, near_splats, far_lit_splats, seen_splats, splats;  ///< in the buffer, as struct Splats.
    GLsizei spray;                               ///< in the buffer
    SpraySorted::Part spray_with_puffs, spray_without;
    GLsizei vertices;                            ///< in the buffer, without glass
};

/// Texture units, the same in every pass.
enum Unit {
    unit_depths, unit_surface, unit_shadow_all, unit_shadow_bodies, unit_snow_outward, unit_snow_light,
    unit_relief, unit_spray_shadow, unit_wide_depths, unit_shadow_depths, unit_raw_depths,
    unit_values, unit_palette, unit_shadow_bounds, unit_shadow_far
};

/// The passes of a picture, in the order in which they run, and the OpenGL objects that they keep.
struct Renderer::Passes {
    explicit Passes(const Picture&);
    Image draw(const ParticleView&, const std::vector<Solid>&, const Camera&, double time);
    void draw_moment(const ParticleView&, const std::vector<Solid>&, const Camera&, double time, int moment);

    Frame prepare(ParticleView, const std::vector<Solid>&, const Camera&, double time);
    void prepare_solids(Frame&, const std::vector<Solid>&, double time);
    void draw_shadows(const Frame&);
    void bound_shadows();
    void draw_surfaces(const Frame&);
    void smooth_depth(const Frame&);
    void shade(const Frame&);
    void draw_nodes(const Frame&);
    void draw_glass(const Frame&);
    void make_lens(const Eigen::Vector2i& samples);
    void blur_by_lens(const Frame&, int moment);
    void draw_spray(const Frame&);
    void expose(int moments, bool first);
    void develop();
    Image read_back();

    void upload_snow(Frame&, const Splats&);
    void upload_volume(const VolumeCells&);
    const Program& shading_program(const std::string& name, const std::vector<std::string>& files,
                                   const BodyDistances&);
    const Program& solid_program(Look, const BodyDistances&);
    void set_view(const Program&, const View&) const;
    void set_light(const Program&, const Frame&) const;  ///< with the program in use
    void set_bodies(const Program&, const BodyDistances&) const;

    EglContext context;  // first: it must outlive the rest
    GLLimits limits = sufficient_limits(context.description());  // before any shader is compiled
    float max_point_size = std::min(limits.point_size, 255.0f);  ///< [samples]; the same picture wherever more is possible.
    Picture picture;
    Effort effort;
    int margin = 0;  ///< [samples]
    Eigen::Vector2i developed_size;  ///< what is read back [pixels]; fewer than the picture's in a draft.

    Buffer splats = make_buffer(), spray = make_buffer(), mesh = make_buffer(), nodes = make_buffer();
    VertexArray splat_array = make_vertex_array(splats, {3, 1, 1, 1}),
                spray_array = make_vertex_array(spray, {3, 3, 1, 1, 1, 1, 1, 1}, 2),
                spray_line_array = make_vertex_array(spray, {3, 3, 1, 1, 1, 1, 1, 1}),
                mesh_array = make_vertex_array(mesh, {3, 3}), no_array = make_vertex_array(mesh, {}),
                node_array = make_vertex_array(nodes, {3});
    Texture relief = make_tile_texture(Relief::size, snow_relief().levels);
    Sampler quick_reader = make_mipmap_reader();  ///< of the relief, where a step between sizes does not show.
    Sampler depth_reader = make_depth_reader(unit_shadow_depths);
    Texture shadow_all, shadow_bodies, shadow_far, spray_shadow, shadow_blocks[2], shadow_bounds, snow_outward = make_volume_texture(),
                                                     snow_light = make_volume_texture();
    Texture depth_buffer, surface, depth, smooth_depths[3], light, blurred, lens_reach[2], film, values, palette, developed;
    std::map<std::pair<std::string, std::array<int, 4>>, Program> shading_programs;  ///< made when they are first needed.
    const Texture *fine = nullptr, *wide = nullptr;  ///< of them: over a grain, over a lump.
    Framebuffer shadow_all_target, shadow_bodies_target, shadow_far_target, spray_shadow_target, shadow_blocks_target[2],
        shadow_bounds_target, surface_target,
        smooth_target[3], light_target, lens_reach_target[2], lens_target, blurred_target, film_target, developed_target;
    const Texture* picture_light = nullptr;  ///< what is to be exposed.
    Eigen::Vector2i lens_samples{0, 0};      ///< of the textures behind it: as few as can be until it is needed.
    Program shadow_mesh_program{{"shadow_mesh.vert"}, {"shadow_mesh.frag"}},
        shadow_splat_program{{"shadow_splat.vert"}, {"shadow_splat.frag"}},
        shadow_spray_program{{"shadow_spray.vert"}, {"shadow_spray.frag"}},
        shadow_blocks_program{{"full_screen.vert"}, {"shadow_blocks.frag"}},
        shadow_bounds_program{{"full_screen.vert"}, {"shadow_bounds.frag"}},
        mesh_program{{"mesh.vert"}, {"mesh.frag"}}, plane_program{{"full_screen.vert"}, {"plane.frag"}},
        splat_program{{"splat.vert"}, {"splat.frag"}, {{"faces", 0}}},
        near_splat_program{{"splat.vert"}, {"splat.frag"}, {{"faces", 1}}}, smooth_program{{"full_screen.vert"}, {"smooth.frag"}},
        sky_program{{"full_screen.vert"}, {"light.glsl", "country.glsl", "shade_sky.frag"}},
        glass_program{{"mesh.vert"}, {"light.glsl", "country.glsl", "glass.frag"}},
        puff_program{{"light.glsl", "lens.glsl", "spray.vert"}, {"spray.frag"}, {{"puffs", 1}, {"lines", 0}}},
        grain_program{{"light.glsl", "lens.glsl", "spray.vert"}, {"spray.frag"}, {{"puffs", 0}, {"lines", 0}}},
        streak_program{{"light.glsl", "lens.glsl", "spray.vert"}, {"spray.frag"}, {{"puffs", 0}, {"lines", 1}}},
        node_program{{"node.vert"}, {"node.frag"}}, lens_program{{"full_screen.vert"}, {"light.glsl", "lens.glsl", "lens.frag"}},
        lens_reach_program{{"full_screen.vert"}, {"lens.glsl", "lens_reach.frag"}, {{"around", 0}}},
        lens_reach_around_program{{"full_screen.vert"}, {"lens.glsl", "lens_reach.frag"}, {{"around", 1}}},
        expose_program{{"full_screen.vert"}, {"expose.frag"}, {{"edge", std::max(static_cast<int>(effort.edge), 1)}}},
        develop_program{{"full_screen.vert"}, {"develop.frag"}};
};

}  // namespace firn
