#include "render/camera.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn {

namespace {

/// Eye, target and field of view, as one vector that is interpolated.
using State = Eigen::Matrix<double, 7, 1>;

State state_of(const CameraKey& key) {
    State s;
    s << key.eye, key.target, key.field_of_view;
    return s;
}

/// ds/dt at key i: the mean of the slopes to either side, each weighted by the other side's time; zero at the
/// ends, where the camera comes to rest.
State slope_at(const std::vector<CameraKey>& keys, std::size_t i) {
    if (i == 0 || i + 1 == keys.size()) return State::Zero();
    const double before = keys[i].time - keys[i - 1].time, after = keys[i + 1].time - keys[i].time;
    const State left = (state_of(keys[i]) - state_of(keys[i - 1])) / before,
                right = (state_of(keys[i + 1]) - state_of(keys[i])) / after;
    return (after * left + before * right) / (before + after);
}

State interpolated(const std::vector<CameraKey>& keys, double time) {
    if (time <= keys.front().time) return state_of(keys.front());
    if (time >= keys.back().time) return state_of(keys.back());
    std::size_t i = 0;
    while (keys[i + 1].time <= time) ++i;
    const double length = keys[i + 1].time - keys[i].time, t = (time - keys[i].time) / length;
    const double t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * state_of(keys[i]) + (t3 - 2 * t2 + t) * length * slope_at(keys, i) +
           (-2 * t3 + 3 * t2) * state_of(keys[i + 1]) + (t3 - t2) * length * slope_at(keys, i + 1);
}

Vec3d forward_of(const Camera& camera) { return (camera.target - camera.eye).normalized(); }

/// But for its top.
Camera moved(const Camera& camera, double time) {
    Camera now = camera;
    now.keyframes.clear();
    now.orbit = 0;
    if (!camera.keyframes.empty()) {
        const State s = interpolated(camera.keyframes, time);
        now.eye = s.head<3>(), now.target = s.segment<3>(3), now.field_of_view = s[6];
    }
    const double angle = camera.orbit * time * std::numbers::pi / 180;
    now.eye = now.target + Eigen::AngleAxisd(angle, Vec3d::UnitY()) * (now.eye - now.target);
    if (camera.orbit != 0) now.top = Eigen::AngleAxisd(angle, Vec3d::UnitY()) * usual_top(forward_of(now));
    return now;
}

/// The nearest time that tells, by steps that double; before rather than after.
std::optional<Vec3d> top_about(const Camera& camera, double time) {
    for (double away = 1.0 / 1024; away < 1024; away *= 2)
        for (const double then : {time - away, time + away})
            if (const Vec3d forward = forward_of(moved(camera, then)); !is_vertical(forward))
                return Vec3d(-forward.y() * forward.x(), 0, -forward.y() * forward.z()).normalized();
    return {};
}

}  // namespace

bool is_vertical(const Vec3d& forward) { return std::abs(forward.y()) >= 0.99999; }

Vec3d usual_top(const Vec3d& forward) { return {0, 0, forward.y() > 0 ? 1.0 : -1.0}; }

Camera camera_at(const Camera& camera, double time) {
    Camera now = moved(camera, time);
    if (!camera.keyframes.empty() && is_vertical(forward_of(now)))
        if (const auto top = top_about(camera, time)) now.top = top;
    return now;
}

}  // namespace firn
