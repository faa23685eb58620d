#pragma once

namespace firn {

enum class Quality { draft, preview, final };

/// What a picture is to be: size and effort.
struct Picture {
    int width = 1280, height = 720;    ///< [pixels], 1 to 16384 each.
    Quality quality = Quality::final;  ///< draft: 1 sample a pixel; preview: 1, softer shadows; final: 2×2.
    double sun_azimuth = 180;          ///< [degrees] from +x towards +z: where the light comes from.
    double sun_elevation = 32;         ///< [degrees] above the horizon.
    double exposure = 1;               ///< factor on the light before the tone curve.
};

}  // namespace firn
