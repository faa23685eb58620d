#pragma once
#include "render/renderer.h"

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <memory>

// Small pictures, and what to ask of them.

namespace firn {

inline constexpr float spacing = 0.02f;  ///< of the particles [m]

inline Picture small_picture(Quality quality = Quality::draft) {
    Picture picture;
    picture.width = 160, picture.height = 90, picture.quality = quality;
    picture.sun_azimuth = 180;  // from the left of a camera that looks along −z
    return picture;
}

/// None where this machine has no OpenGL, with a warning that says so.
inline std::unique_ptr<Renderer> renderer_for(const Picture& picture) {
    try {
        return std::make_unique<Renderer>(picture);
    } catch (const GLError& error) {
        WARN("skipped, as there is no OpenGL here: " << error.what());
        return nullptr;
    }
}

/// A ball of particles on a lattice.
inline std::vector<float> ball(const Vec3d& center, double radius) {
    std::vector<float> x;
    const int n = static_cast<int>(radius / spacing);
    for (int k = -n; k <= n; ++k)
        for (int j = -n; j <= n; ++j)
            for (int i = -n; i <= n; ++i) {
                const Vec3d p = Vec3d(i, j, k) * spacing;
                if (p.norm() > radius) continue;
                for (int a = 0; a < 3; ++a) x.push_back(static_cast<float>(center[a] + p[a]));
            }
    return x;
}

inline const std::vector<Solid> ground = {{{Plane{}}}};
inline const Camera front{{0, 0.6, 2.4}, {0, 0.3, 0}, 40};

/// Mean of a pixel's channels, 0 to 255.
inline double brightness(const Image& image, int x, int y) {
    const std::size_t p = 3 * (static_cast<std::size_t>(y) * image.width + x);
    return (image.pixels[p] + image.pixels[p + 1] + image.pixels[p + 2]) / 3.0;
}

/// Pixel of a world position, counted in pixels from the upper left corner of the picture. By hand, for a
/// camera that looks along −z.
inline std::array<double, 2> pixel_of(const Vec3d& x, const Camera& camera, const Image& image) {
    const double depth = camera.eye.z() - x.z();
    const double scale = image.height / 2.0 / std::tan(camera.field_of_view / 2 * EIGEN_PI / 180) / depth;
    return {image.width / 2.0 + scale * (x.x() - camera.eye.x()),
            image.height / 2.0 - scale * (x.y() - camera.eye.y())};
}

/// Middle of where two pictures differ, in pixels, and of how many pixels do.
struct Spot {
    double x = 0, y = 0;
    int pixels = 0;
};
inline Spot difference_of(const Image& a, const Image& b) {
    Spot spot;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x)
            if (std::abs(brightness(a, x, y) - brightness(b, x, y)) > 3)
                spot.x += x + 0.5, spot.y += y + 0.5, ++spot.pixels;
    spot.x /= std::max(spot.pixels, 1), spot.y /= std::max(spot.pixels, 1);
    return spot;
}

}  // namespace firn
