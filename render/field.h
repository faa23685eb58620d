#pragma once
#include <Eigen/Core>

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

/// 1 where all of the 3×3×3 cells around have at least that value; nothing lies outside.
std::vector<std::uint8_t> enclosed_cells(const Field&, float least);

/// [1 2 1]/4 along each axis.
Field smoothed(const Field&);

/// Of every cell −∂ρ/∂x, −∂ρ/∂y, −∂ρ/∂z, over two cells, and ρ itself: four numbers of 16 bits, as textures take them.
std::vector<Eigen::half> outward_of(const Field& rho);

}  // namespace firn
