#pragma once
#include "sim/types.h"

#include <optional>
#include <vector>

namespace firn {

/// Where a moving camera is at a moment.
struct CameraKey {
    double time = 0;            ///< [s]
    Vec3d eye{0, 1, 3};         ///< [m]
    Vec3d target{0, 0, 0};      ///< [m]
    double field_of_view = 40;  ///< vertical [degrees].
};

/// A camera, y up: a pinhole, or a lens with an aperture.
struct Camera {
    Vec3d eye{0, 1, 3};               ///< [m]
    Vec3d target{0, 0, 0};            ///< [m]
    double field_of_view = 40;        ///< vertical [degrees].
    double aperture = 0;              ///< diameter of the lens [m]; 0: all is sharp.
    std::optional<double> focus = {}; ///< distance that is sharp [m]; none: the target's.
    double orbit = 0;                 ///< turns about the vertical through the target [degrees/s].
    std::optional<Vec3d> top = {};    ///< to where the picture's top points that is seen straight up or down; none: usual_top().
    std::vector<CameraKey> keyframes = {};  ///< stand instead of eye, target and field of view where there are any.
};

/// Whether y says nothing of where the top is.
bool is_vertical(const Vec3d& forward);

/// Of a picture straight down −z, straight up +z.
Vec3d usual_top(const Vec3d& forward);

/// The camera as it stands at `time` [s], without keyframes and orbit: cubic Hermite curves through the
/// keyframes with the slopes of Catmull and Rom for uneven times; at rest before the first and after the last.
/// Where it looks straight up or down it has not turned since, or before.
Camera camera_at(const Camera&, double time);

}  // namespace firn
