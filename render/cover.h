#pragma once
#include "render/density.h"

#include <Eigen/Geometry>

#include <atomic>
#include <cstdint>
#include <vector>

namespace firn {

/// How far sight goes in snow: cells through which it does not, in bytes, and whether a block of 4³ has any.
struct Cover {
    Eigen::Vector3f origin;
    float cell;
    Eigen::Vector3i size, blocks;
    std::vector<std::uint8_t> cells, any;
    Eigen::AlignedBox3f filled;  ///< holds all blocks that have any [cells].

    explicit Cover(const Density&);
    /// Whether two cells of unbroken snow, or more of looser, lie before a point, up to a distance [m].
    bool covers(const Eigen::Vector3f& x, const Eigen::Vector3f& direction, float distance,
                float from_cells = 1) const;
};

/// Whether snow lies in front of a splat, as seen from the eye; that within `from_cells` does not count.
bool is_covered(const Eigen::Vector3f& splat, const Eigen::Vector3f& eye, const Cover&, float from_cells = 1);

/// Smoothed density from which a particle is in unbroken snow.
inline constexpr float whole_from = 0.27f;

/// What a cell's particles are and what hides them; `whole`: all in unbroken snow, none is spray.
enum Hidden : std::uint8_t { from_eye = 1, from_sun = 2, enclosed = 4, whole = 8, not_asked = 16 };

/// What hides the cells of a cover from eye and sun. The eye's answer is asked for when it is first wanted; whichever
/// thread asks first, it is the same.
class HiddenCells {
public:
    HiddenCells(const Density&, const Density& soft, const Cover&, const Eigen::Vector3f& eye,
                const Eigen::Vector3f& to_sun);
    bool is_enclosed(std::size_t cell) { return known(cell) & enclosed; }
    /// What is known of a cell: it may have to be asked for what hides it from the eye.
    std::uint8_t known(std::size_t cell) { return at(cell).load(std::memory_order_relaxed); }
    std::uint8_t ask(std::size_t cell);
    /// from_eye, from_sun: what hides the middle of an enclosed cell.
    int of_enclosed(int i, int j, int k);

private:
    std::atomic_ref<std::uint8_t> at(std::size_t cell) { return std::atomic_ref<std::uint8_t>(cells_[cell]); }

    const Cover& cover_;
    Eigen::Vector3f eye_;
    std::vector<std::uint8_t> cells_;
};

}  // namespace firn
