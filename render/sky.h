#pragma once
#include <Eigen/Core>

namespace firn {

/// Light of sun and sky, as radiances of a white matt surface; red, green, blue [1].
struct SkyLight {
    Eigen::Vector3f sun;      ///< of one that faces the sun.
    Eigen::Vector3f sky;      ///< of one that sees all of the sky.
    Eigen::Vector3f horizon;  ///< colour of the sky low down
    Eigen::Vector3f zenith;   ///< and straight up.
};

/// By the height of the sun [degrees]: white at noon, golden when low, blue once it has set. The eye gets used
/// to less light, though not to all of it.
SkyLight sky_light_at(double sun_elevation);

}  // namespace firn
