#include "render/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn {

namespace {

using Eigen::Vector3d;

double smoothstep(double a, double b, double x) {
    const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double luminance(const Vector3d& c) { return Vector3d(0.2126, 0.7152, 0.0722).dot(c); }

/// Air masses on the sun's way through the atmosphere [Kasten and Young 1989].
double air_mass(double elevation) {
    const double e = std::max(elevation, -2.0);
    return 1 / (std::sin(e * std::numbers::pi / 180) + 0.50572 * std::pow(e + 6.07995, -1.6364));
}

struct Light {
    Vector3d sun, sky, horizon, zenith;
};

Light unadapted(double elevation) {
    const Vector3d optical_depth(0.055, 0.115, 0.215);  // of clear, cold air, per air mass
    const double day = smoothstep(-14, 24, elevation), set = smoothstep(-1.5, 1.0, elevation);
    const double golden = smoothstep(-8, 1, elevation) * (1 - smoothstep(4, 22, elevation));
    Light light;
    light.sun = 1.30 * set * (-air_mass(elevation) * optical_depth).array().exp().matrix();
    light.zenith = day * Vector3d(0.060, 0.16, 0.41);
    const Vector3d cool(0.50, 0.61, 0.745), warm(0.78, 0.56, 0.42);
    light.horizon = day * (cool + 0.8 * golden * (warm - cool));
    // On level ground 0.41 of all light with the sun at 18°, 0.28 at 32° and 0.18 at 60°: a sky without clouds.
    light.sky = day * (Vector3d(0.161, 0.223, 0.307) + golden * Vector3d(0.018, 0.0, -0.007));
    return light;
}

double on_the_ground(const Light& light, double elevation) {
    return luminance(std::max(std::sin(elevation * std::numbers::pi / 180), 0.0) * light.sun + light.sky);
}

}  // namespace

SkyLight sky_light_at(double sun_elevation) {
    const Light light = unadapted(sun_elevation);
    constexpr double usual = 32;  // degrees: what exposure 1 is made for
    const double share =
        on_the_ground(unadapted(usual), usual) / std::max(on_the_ground(light, sun_elevation), 1e-4);
    const double gain = std::min(std::pow(share, 0.75), 12.0);
    const auto seen = [&](const Vector3d& c) { return Eigen::Vector3f((gain * c).cast<float>()); };
    return {seen(light.sun), seen(light.sky), seen(light.horizon), seen(light.zenith)};
}

}  // namespace firn
