#pragma once
#include "render/density.h"

namespace firn {

/// Snow between every cell's centre and a light infinitely far in direction `to_light` (unit): ∫ρ ds, counted
/// in particle spacings of unbroken snow; no more than `most`. `rows_whole`: quicker, in steps of up to 2.4 cells.
Field thickness_towards(const Density&, float spacing, const Eigen::Vector3f& to_light, float most = INFINITY,
                        bool rows_whole = false);

/// What the shaders know of the light at a cell's centre, all as shares of what there is without snow [1]; as textures
/// take it.
struct SnowLight {
    Eigen::half sun[3];  ///< red, green and blue of the sun that comes through, scattered.
    Eigen::half sky;     ///< of the sky's light.
};
static_assert(sizeof(SnowLight) == 4 * sizeof(Eigen::half));

std::vector<SnowLight> light_in_snow(const Density&, float spacing, const Eigen::Vector3f& to_sun);

}  // namespace firn
