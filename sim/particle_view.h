#pragma once
#include <span>

namespace firn {

/// Particles as the renderer sees them, in the order in which they were sampled: entry n is the same particle
/// in every frame.
struct ParticleView {
    std::span<const float> x;  ///< positions [m], 3n: x y z x y z …
    std::span<const float> v;  ///< velocities [m/s], 3n, or empty.
    float spacing = 0;         ///< mean distance of neighbours at the start [m]: h / ∛(particles per cell).
    std::span<const float> value = {};  ///< what a colour map shows, 0 to 1, n, or empty.
    float grid_spacing = 0;             ///< h [m], where the grid is to be seen.
    std::size_t size() const { return x.size() / 3; }
};

}  // namespace firn
