#pragma once
#include "render/density.h"

namespace firn {

/// One disc-shaped point that stands for a particle. Plain floats, as the vertex buffer wants them.
struct Splat {
    float x, y, z;  ///< centre [m].
    float radius;   ///< [m]
    float hash;     ///< 0 to 1, of the particle's number: the same in every frame.
};

struct Splats {
    std::vector<Splat> all;
    std::size_t seen = 0;  ///< so many, the first, may be seen; the others only throw shadows.
};

/// The particles that can be seen or throw a shadow: those inside unbroken snow are left out, and one large
/// splat fills every cell of the innermost layer, so that nothing shines through between the outer ones.
Splats visible_splats(const ParticleView&, const Density&, const Eigen::Vector3f& eye);

/// Whether unbroken snow lies right in front of a splat, as seen from the eye: it is on a lump's far side.
bool is_covered(const Eigen::Vector3f& splat, const Eigen::Vector3f& eye, const Density&);

}  // namespace firn
