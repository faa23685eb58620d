#include "render/renderer.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace firn {

/// A corner at (x, y, z) from the middle, z towards the camera, is inside the picture's share m where
///   |x| ≤ m tan_x (d − z)  and  |y| ≤ m tan_y (d − z):  the largest d that a corner asks for is taken.
Camera framing(const Bounds& box, double aspect_ratio) {
    Camera camera;
    if (box.empty() || !box.lower.allFinite() || !box.upper.allFinite()) return camera;
    const Vec3d center = 0.5 * (box.lower + box.upper), half = 0.5 * (box.upper - box.lower);
    constexpr double share = 0.62;  // of the picture's half width and height
    const double tan_y = std::tan(camera.field_of_view / 2 * std::numbers::pi / 180);
    const double tan_x = tan_y * aspect_ratio;
    const Vec3d back = Vec3d(0.25, 0.2, 1).normalized();  // from low down: the horizon is in the picture
    const Vec3d right = Vec3d(0, 1, 0).cross(back).normalized(), up = back.cross(right);

    double distance = 1e-3;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const Vec3d p = sign.cwiseProduct(half);
        const double z = back.dot(p);
        distance = std::max(distance, z + std::abs(right.dot(p)) / (share * tan_x));
        distance = std::max(distance, z + std::abs(up.dot(p)) / (share * tan_y));
    }
    camera.target = center;
    camera.eye = center + distance * back;
    return camera;
}

}  // namespace firn
