#include "render/renderer.h"
#include "render/sky.h"
#include "render/view.h"

#include <catch2/catch.hpp>

#include <Eigen/Geometry>

using namespace firn;

namespace {

/// Of a world position: x and y from −1 to 1 over the picture with its margin, and w in front of the eye.
Eigen::Vector3f projected(const View& view, const Vec3d& x) {
    const Eigen::Vector4f clip = view.projection() * x.cast<float>().homogeneous();
    return {clip.x() / clip.w(), clip.y() / clip.w(), clip.w()};
}

View view_of(const Camera& camera, int width, int height) {
    Picture picture;
    picture.width = width, picture.height = height;
    return view_of(camera, picture, 1, 0, 0.01);
}

}  // namespace

TEST_CASE("the target is in the middle of the picture, right is right and up is up", "[camera]") {
    const Camera camera{{1, 2, 5}, {0, 1, -2}, 50};
    const View view = view_of(camera, 160, 90);
    const Eigen::Vector3f middle = projected(view, camera.target);
    CHECK(middle.x() == Approx(0).margin(1e-5));
    CHECK(middle.y() == Approx(0).margin(1e-5));
    CHECK(middle.z() == Approx((camera.target - camera.eye).norm()));
    CHECK(projected(view, camera.target + Vec3d(0, 0.1, 0)).y() > 0);
    CHECK(projected(view, camera.target + Vec3d(0.1, 0, 0)).x() > 0);
}

TEST_CASE("the field of view is the picture's height", "[camera]") {
    const Camera camera{{0, 0, 4}, {0, 0, 0}, 60};
    const double edge = 4 * std::tan(30 * EIGEN_PI / 180);
    CHECK(projected(view_of(camera, 160, 90), {0, edge, 0}).y() == Approx(1).epsilon(1e-5));
    CHECK(projected(view_of(camera, 160, 90), {edge * 160 / 90, 0, 0}).x() == Approx(1).epsilon(1e-5));
}

TEST_CASE("a camera may look straight down or up, or nowhere", "[camera]") {
    for (const Vec3d& target : {Vec3d(0, -3, 0), Vec3d(0, 3, 0), Vec3d(0, 0, 0)}) {
        const View view = view_of(Camera{{0, 0, 0}, target, 40}, 100, 100);
        CHECK(view.projection().allFinite());
        CHECK((view.basis.transpose() * view.basis - Eigen::Matrix3f::Identity()).norm() < 1e-6);
    }
}

TEST_CASE("a framing camera has the whole box in the picture and does not waste it", "[camera]") {
    for (const Vec3d& size : {Vec3d(1, 1, 1), Vec3d(10, 0.1, 3), Vec3d(0.01, 5, 0.01), Vec3d(0, 0, 0)})
        for (const double aspect : {16.0 / 9, 1.0, 0.5}) {
            CAPTURE(size.transpose(), aspect);
            Bounds box;
            box.extend(Vec3d(7, -3, 2));
            box.extend(Vec3d(7, -3, 2) + size);
            const Camera camera = framing(box, aspect);
            const View view = view_of(camera, static_cast<int>(900 * aspect), 900);
            float outermost = 0;
            for (int corner = 0; corner < 8; ++corner) {
                const Vec3d x(corner & 1 ? box.upper.x() : box.lower.x(),
                              corner & 2 ? box.upper.y() : box.lower.y(),
                              corner & 4 ? box.upper.z() : box.lower.z());
                const Eigen::Vector3f p = projected(view, x);
                REQUIRE(p.z() > 0);
                outermost = std::max({outermost, std::abs(p.x()), std::abs(p.y())});
            }
            CHECK(outermost < 0.9f);
            if (size.norm() > 0) CHECK(outermost > 0.4f);
            CHECK(camera.eye.y() > camera.target.y());
        }
}

TEST_CASE("where there is nothing to frame, the camera is the default", "[camera]") {
    CHECK(framing(Bounds{}, 1.5).eye == Camera{}.eye);
    Bounds infinite;
    infinite.extend(Vec3d::Constant(-INFINITY));
    infinite.extend(Vec3d::Constant(INFINITY));
    CHECK(framing(infinite, 1.5).eye == Camera{}.eye);
}

TEST_CASE("a camera passes through its keyframes, smoothly and at rest at both ends", "[camera]") {
    Camera camera;
    camera.keyframes = {{0, {0, 1, 3}, {0, 0, 0}, 40}, {1, {2, 1, 3}, {0, 0.5, 0}, 30}, {3, {2, 4, 3}, {1, 0, 0}, 50}};
    for (const CameraKey& key : camera.keyframes) {
        const Camera now = camera_at(camera, key.time);
        CHECK((now.eye - key.eye).norm() < 1e-12);
        CHECK((now.target - key.target).norm() < 1e-12);
        CHECK(now.field_of_view == Approx(key.field_of_view));
        for (const double dt : {-1e-6, 1e-6})
            CHECK((camera_at(camera, key.time + dt).eye - key.eye).norm() < 1e-5);
    }
    CHECK(camera_at(camera, -1).eye == camera.keyframes.front().eye);
    CHECK(camera_at(camera, 9).eye == camera.keyframes.back().eye);
    constexpr double dt = 1e-4;
    const auto speed = [&](double t) {
        return Vec3d((camera_at(camera, t + dt).eye - camera_at(camera, t - dt).eye) / (2 * dt));
    };
    CHECK(speed(0).norm() < 1e-2);
    CHECK(speed(3).norm() < 1e-2);
    CHECK((speed(1 - 2 * dt) - speed(1 + 2 * dt)).norm() < 1e-2);
    // That of the parabola through all three: slopes of 2 before and 0 after in x, 0 and 3/2 in y.
    CHECK((speed(1) - Vec3d(4.0 / 3, 0.5, 0)).norm() < 1e-3);
}

TEST_CASE("an orbit keeps the distance and looks at the target", "[camera]") {
    Camera camera{{3, 1, 0}, {1, 0.5, 0}, 40};
    camera.orbit = 90;
    const Camera quarter = camera_at(camera, 1);
    CHECK((quarter.eye - Vec3d(1, 1, -2)).norm() < 1e-12);
    CHECK(quarter.target == camera.target);
    CHECK((camera_at(camera, 4).eye - camera.eye).norm() < 1e-12);
}

TEST_CASE("a path that comes to look straight down turns nothing on its last step", "[camera]") {
    for (const Vec3d& start : {Vec3d(3, 1, 0), Vec3d(0, 1, 3), Vec3d(-1, 1, -2)}) {
        Camera camera;
        camera.keyframes = {{0, start, {0, 0, 0}, 40}, {1, {0, 3, 0}, {0, 0, 0}, 40}};
        const auto right = [&](double time) { return Eigen::Vector3f(view_of(camera_at(camera, time), 90, 90).basis.col(0)); };
        CAPTURE(start.transpose());
        for (const double before : {0.5, 0.9, 0.99, 0.999}) CHECK((right(1) - right(before)).norm() < 1e-3);
        CHECK((right(9) - right(1)).norm() == 0);
    }
}

TEST_CASE("an orbit turns the picture of what is straight below", "[camera]") {
    Camera camera{{0, 3, 0}, {0, 0, 0}, 40};
    camera.orbit = 90;
    const auto right = [&](double time) { return Vec3d(view_of(camera_at(camera, time), 90, 90).basis.col(0).cast<double>()); };
    CHECK((right(0) - Vec3d(1, 0, 0)).norm() < 1e-6);
    CHECK((right(1) - Vec3d(0, 0, -1)).norm() < 1e-6);
}

TEST_CASE("the sun stands where azimuth and elevation say", "[camera]") {
    Picture picture;
    picture.sun_azimuth = 90, picture.sun_elevation = 30;
    CHECK((sun_direction(picture) - Eigen::Vector3f(0, 0.5f, std::sqrt(0.75f))).norm() < 1e-6);
    picture.sun_azimuth = 0, picture.sun_elevation = 0;
    CHECK((sun_direction(picture) - Eigen::Vector3f(1, 0, 0)).norm() < 1e-6);
}

TEST_CASE("the sky gives less of the light the higher the sun: half when it is low, under a third at 32 degrees", "[camera]") {
    double before = 0.6;
    for (const double elevation : {12.0, 18.0, 32.0, 60.0}) {
        const SkyLight light = sky_light_at(elevation);
        const double sky = light.sky.y(), sun = std::sin(elevation * EIGEN_PI / 180) * light.sun.y(), share = sky / (sun + sky);
        CAPTURE(elevation, share);
        CHECK(share < before);
        CHECK(share > 0.1);
        if (elevation == 32) CHECK(share < 1 / 3.0);
        before = share;
    }
}

TEST_CASE("the shadow map holds its ball, the sun's side nearer", "[camera]") {
    const Eigen::Vector3f to_sun = Eigen::Vector3f(-1, 2, 0.5).normalized(), center(3, 1, -2);
    const ShadowView shadow = shadow_view(to_sun, center, 1.7f, 512);
    const auto at = [&](const Eigen::Vector3f& x) {
        return (shadow.matrix * x.homogeneous()).hnormalized().eval();
    };
    for (const Eigen::Vector3f& direction : {Eigen::Vector3f(1, 0, 0), Eigen::Vector3f(0, 1, 0), to_sun})
        CHECK(at(center + 1.69f * direction).cwiseAbs().maxCoeff() < 1.01f);
    CHECK(at(center + to_sun).z() < at(center - to_sun).z());
    CHECK((at(center + to_sun) - at(center)).head<2>().norm() < 1e-5);
}
