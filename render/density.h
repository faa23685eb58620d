#pragma once
#include "sim/particle_view.h"

#include <Eigen/Core>

#include <cmath>
#include <cstdint>
#include <vector>

namespace firn {

/// Numbers on cells of a box, x fastest. Values belong to the cells' centres.
struct Field {
    Eigen::Vector3i size{0, 0, 0};
    std::vector<float> values;

    std::size_t index(int i, int j, int k) const {
        return (static_cast<std::size_t>(k) * size.y() + j) * size.x() + i;
    }
};

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

/// 1 where all of the 3×3×3 cells around have at least that value; nothing lies outside.
std::vector<std::uint8_t> enclosed_cells(const Field&, float least);

/// [1 2 1]/4 along each axis.
Field smoothed(const Field&);

/// The mean of every eight cells, with the same lower corner.
Density halved(const Density&);

/// Of every cell −∂ρ/∂x, −∂ρ/∂y, −∂ρ/∂z, over two cells, and ρ itself: four numbers of 16 bits, as textures take them.
std::vector<Eigen::half> outward_of(const Field& rho);

}  // namespace firn
