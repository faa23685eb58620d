#include "render/view.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>

namespace firn {

namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Columns right, up, forward; y is up unless one looks along it.
Mat3d basis_along(const Vec3d& forward, const Vec3d& top) {
    const Vec3d y = is_vertical(forward) ? top : Vec3d(0, 1, 0);
    Mat3d basis;
    basis.col(2) = forward;
    basis.col(0) = forward.cross(y).normalized();
    basis.col(1) = basis.col(0).cross(forward);
    return basis;
}

}  // namespace

Eigen::Vector2i samples_of(const Picture& picture, double edge, int margin) {
    const Eigen::Vector2d size(picture.width, picture.height);
    return (edge * size.array()).ceil().cast<int>() + 2 * margin;
}

View view_of(const Camera& camera, const Picture& picture, double edge, int margin, double spacing) {
    const Vec3d to_target = camera.target - camera.eye;
    const double distance = to_target.norm(), scale = distance > 0 ? distance : 1;
    const Vec3d forward = distance > 0 ? Vec3d(to_target / distance) : Vec3d(0, 0, -1);
    View view;
    view.eye = camera.eye.cast<float>();
    view.basis = basis_along(forward, camera.top.value_or(usual_top(forward))).cast<float>();
    view.samples = samples_of(picture, edge, margin);
    view.sample_tan =
        static_cast<float>(2 * std::tan(radians(camera.field_of_view) / 2) / (picture.height * edge));
    view.near_depth = static_cast<float>(std::min(0.01 * scale, 8 * spacing));
    view.haze_distance = static_cast<float>(60 * scale);
    return view;
}

Eigen::Matrix4f View::projection() const {
    const Eigen::Vector2f scale = (2 / sample_tan) * samples.cast<float>().cwiseInverse();
    Eigen::Matrix4f matrix = Eigen::Matrix4f::Zero();
    matrix.block<1, 3>(0, 0) = scale.x() * basis.col(0).transpose();
    matrix.block<1, 3>(1, 0) = scale.y() * basis.col(1).transpose();
    matrix.block<1, 3>(2, 0) = basis.col(2).transpose();
    matrix.block<1, 3>(3, 0) = basis.col(2).transpose();
    matrix.col(3).head<3>() = -matrix.topLeftCorner<3, 3>() * eye;
    matrix(2, 3) -= 2 * near_depth;
    matrix(3, 3) = -basis.col(2).dot(eye);
    return matrix;
}

Eigen::Vector3f sun_direction(const Picture& picture) {
    const double azimuth = radians(picture.sun_azimuth), elevation = radians(picture.sun_elevation);
    return Vec3d(std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                 std::cos(elevation) * std::sin(azimuth))
        .cast<float>();
}

ShadowView shadow_view(const Eigen::Vector3f& to_sun, const Eigen::Vector3f& center, float radius, int size) {
    const double step = 0.25;
    const double r = std::exp2(std::ceil(std::log2(std::max(radius, 1e-6f)) / step) * step);
    const double texel = 2 * r / size;
    const Vec3d forward = -to_sun.cast<double>();
    const Mat3d basis = basis_along(forward, usual_top(forward));
    Vec3d c = basis.transpose() * center.cast<double>();
    c = (c.array() / texel).round() * texel;
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = basis.transpose() / r;
    matrix.topRightCorner<3, 1>() = -c / r;
    return {matrix.cast<float>(), static_cast<float>(texel)};
}

}  // namespace firn
