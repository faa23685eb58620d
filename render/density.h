#pragma once
#include "render/field.h"
#include "sim/particle_view.h"

#include <cmath>

namespace firn {

/// How much snow is where.
struct Density {
    Eigen::Vector3f origin{0, 0, 0};  ///< lower corner [m].
    float cell = 1;  ///< edge of a cell [m]: two particle spacings, more where snow is far spread.
    Field rho;       ///< share of the starting density [1].

    /// Trilinear between the cells' centres; zero outside.
    float at(const Eigen::Vector3f& x) const {
        float result;
        at(&x[0], &x[1], &x[2], 1, &result);
        return result;
    }
    /// The same at so many points.
    void at(const float* x, const float* y, const float* z, std::size_t count, float* result) const;
};

/// A particle that cannot be drawn: not finite, or farther than a float can place to a millimetre.
inline bool drawable(const float* x) {
    constexpr float far_away = 1e5f;  // [m]
    return std::abs(x[0]) < far_away && std::abs(x[1]) < far_away && std::abs(x[2]) < far_away;
}

/// Cells along an edge at most: what every OpenGL 3.3 of the last fifteen years takes in a 3D texture.
inline constexpr int longest_edge = 2048;

/// The grid lies at multiples of the cell, so that it does not swim from frame to frame. Far single particles
/// are left outside where they would cost more than `max_cells`, or more than the longest edge; then cells grow, in
/// steps of a fifth: of a spreading cloud no frame looks much unlike the one before.
Density density_of(const ParticleView&, std::size_t max_cells);

/// The mean of every eight cells, with the same lower corner.
Density halved(const Density&);

}  // namespace firn
