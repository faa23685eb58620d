#pragma once
#include "sim/types.h"

namespace firn {

/// A pinhole camera, y up.
struct Camera {
    Vec3d eye{0, 1, 3};         ///< [m]
    Vec3d target{0, 0, 0};      ///< [m]
    double field_of_view = 40;  ///< vertical [degrees].
};

}  // namespace firn
