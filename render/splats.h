#pragma once
#include "render/cover.h"
#include "render/loose_snow.h"
#include "render/view.h"

#include <cmath>
#include <functional>

namespace firn {

/// One point that stands for a particle. Plain floats, as the vertex buffer wants them.
struct Splat {
    float x, y, z;  ///< centre [m].
    float radius;   ///< [m]
    float hash;     ///< 0 to 1, of the particle's number: the same in every frame.
    float value;    ///< what a colour map shows.
};

/// In one order for both draws: seen ones come first, of them the near ones, whose children show; what the sun
/// reaches throws shadows, and stands at the start of the near ones and from the end of the others on.
struct Splats {
    std::vector<Splat> all;
    std::size_t near_lit = 0;  ///< so many, the first, are near and lit,
    std::size_t near = 0;      ///< so many are near,
    std::size_t far_lit = 0;   ///< and from here on all are lit;
    std::size_t seen = 0;      ///< so many may be seen.
    float nearest = INFINITY;  ///< depth of the nearest of those [m].
    std::vector<SprayPoint> spray;
};

/// Where particles are smaller than the radii, fewer and larger splats stand for them.
struct SplatDetail {
    float radius = 0;   ///< of what may be seen [samples].
    float thrower = 0;  ///< of what only throws shadows [m].
    float crumb =
        0;  ///< of lone ones that are spray to the eye if narrower: a splat's edge is too sharp [samples].
};

/// Of a place from what snow may lie on [m].
using DistanceToBodies = std::function<double(const Eigen::Vector3f&)>;

/// The particles that can be seen or throw a shadow: those inside unbroken snow are left out, and one large
/// splat fills every cell of the innermost layer, so that nothing shines through between the outer ones.
/// `soft` is the smoothed density, which tells snow from spray; a splat wider than `near_radius` [samples] is
/// near. `wide`, in cells four times as wide, tells how far apart the grains of a cloud are.
Splats visible_splats(const ParticleView&, const Density&, const Density& soft, const Density& wide,
                      const View&, const Eigen::Vector3f& to_sun, float near_radius, const DistanceToBodies&,
                      const SplatDetail& = {});

}  // namespace firn
