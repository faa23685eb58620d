#pragma once
#include "render/density.h"
#include "render/view.h"

#include <cmath>

namespace firn {

/// One point that stands for a particle. Plain floats, as the vertex buffer wants them.
struct Splat {
    float x, y, z;  ///< centre [m].
    float radius;   ///< [m]
    float hash;     ///< 0 to 1, of the particle's number: the same in every frame.
    float value;    ///< what a colour map shows.
};

/// A particle that is powder in the air.
struct SprayPoint {
    float x, y, z;     ///< [m]
    float vx, vy, vz;  ///< [m/s]
    float amount;      ///< 0 to 1: how far it has come apart.
    float hash, value;
};

struct Splats {
    std::vector<Splat> all;
    std::size_t near = 0;           ///< so many, the first, are so near that their children show,
    std::size_t seen = 0;           ///< so many may be seen; the others only throw shadows.
    float nearest = INFINITY;       ///< depth of the nearest of those [m].
    std::vector<SprayPoint> spray;  ///< each twice: for both ends of a line.
};

/// The particles that can be seen or throw a shadow: those inside unbroken snow are left out, and one large
/// splat fills every cell of the innermost layer, so that nothing shines through between the outer ones.
/// `soft` is the smoothed density, which tells snow from spray; a splat wider than `near_radius` [samples] is
/// near.
Splats visible_splats(const ParticleView&, const Density&, const Density& soft, const View&,
                      float near_radius);

/// Whether unbroken snow lies right in front of a splat, as seen from the eye: it is on a lump's far side.
bool is_covered(const Eigen::Vector3f& splat, const Eigen::Vector3f& eye, const Density&);

}  // namespace firn
