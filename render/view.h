#pragma once
#include "render/camera.h"
#include "render/picture.h"

#include <Eigen/Core>

namespace firn {

/// The camera as the shaders use it. Samples are pixels times the supersampling, with a margin on all sides:
/// OpenGL drops a point whose centre leaves the picture, though a part of it may still be in.
struct View {
    Eigen::Vector3f eye;      ///< [m]
    Eigen::Matrix3f basis;    ///< columns right, up, forward.
    Eigen::Vector2i samples;  ///< size of the buffers that are drawn into.
    float sample_tan;         ///< width of a sample at unit depth [1].
    float haze_distance;      ///< in which air without end would take all but 1/e of the light [m].
    float near_depth;         ///< nothing closer is seen [m]; depths end at infinity.

    /// Clip coordinates of a world position; depth in the buffer is 1 − near/z, with z along forward.
    Eigen::Matrix4f projection() const;
};

/// Size of the buffers for `edge` samples along a pixel's edge.
Eigen::Vector2i samples_of(const Picture&, double edge, int margin);

/// What is eight spacings of particles [m] away is seen, wherever the target is.
View view_of(const Camera&, const Picture&, double edge, int margin, double spacing);

/// Towards the sun (unit).
Eigen::Vector3f sun_direction(const Picture&);

/// Parallel light on a ball: where it falls in the shadow map.
struct ShadowView {
    Eigen::Matrix4f matrix;  ///< world to clip coordinates.
    float texel;             ///< [m]
};

/// The ball grows in steps and moves by whole texels, so that shadows do not swim from frame to frame.
ShadowView shadow_view(const Eigen::Vector3f& to_sun, const Eigen::Vector3f& center, float radius, int size);

}  // namespace firn
