#pragma once
#include "render/picture.h"

namespace firn {

/// What a quality costs.
struct Effort {
    double edge;          ///< samples along a pixel's edge.
    float least_radius;   ///< [samples] of a splat; where particles are smaller, fewer and larger ones stand for them.
    float least_thrower;  ///< [texels of the shadow map]: the same of what only throws a shadow.
    int shadow_size;      ///< [texels]
    int shadow_search;    ///< samples of it that look for what throws half-shade.
    int shadow_taps;      ///< samples of the shadow map in half-shade.
    float children;       ///< smaller splats about a particle that is near,
    float children_from;  ///< which is one of at least such a radius [samples];
    float all_children;   ///< in a picture: where many are near, each has fewer.
    float puffs;          ///< share of the spray that is drawn as puffs.
    int grains;           ///< drawn of each particle of spray.
    bool fine_light;      ///< in snow: in cells of the density, or twice as wide.
};

Effort effort_of(Quality);

}  // namespace firn
