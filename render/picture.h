#pragma once
#include "sim/shape.h"

#include <optional>

namespace firn {

enum class Quality { draft, preview, final };

/// What the snow's colour shows.
enum class Colour { snow, speed, density, compression, stress, body, particle_id, sleeping };

/// [pixels] of the longest edge, so that no buffer has more than 16384 samples along one: most OpenGLs end there.
constexpr int longest_picture(Quality quality) { return quality == Quality::final ? 8192 : 16384; }

/// What a picture is to be: size, light, effort, and what it shows.
struct Picture {
    int width = 1280, height = 720;    ///< [pixels], 1 to longest_picture each.
    Quality quality = Quality::final;  ///< samples: draft one for 2½×2½ pixels, preview 1, final 2×2 for each.
    double sun_azimuth = 155;          ///< [degrees] from +x towards +z: where the light comes from.
    double sun_elevation = 32;         ///< [degrees] above the horizon.
    double exposure = 1;               ///< factor on the light before the tone curve.
    double shutter = 0.0052;           ///< how long it is open [s], 45° at 24 a second; spray is drawn along its way.
    int motion_samples = 1;            ///< moments of that time that are averaged; 1: only spray is blurred.
    Colour colour = Colour::snow;
    std::optional<double> colour_min, colour_max;  ///< ends of the colour map; none: of the frame's values.
    std::optional<Plane> slice;                    ///< snow that its normal points to is cut away.
    bool grid_nodes = false;                       ///< draws the nodes of the cells that hold snow.
    bool overlay = false;  ///< writes time, Δt and the number of particles into the picture.
};

}  // namespace firn
