#pragma once
#include "app/scene_load.h"
#include "sim/simulation.h"

namespace firn {

/// What the simulation needs to know of the scene.
Setup make_setup(const Scene&);

/// About how many particles the scene will have, without making them.
double expected_particles(const LoadedScene&);

/// The scene's particles at the start, and what looks unintended about them.
struct StartingParticles {
    ParticleSet particles;
    std::vector<std::size_t> counts;    ///< of each body, in the order of the particles.
    std::vector<std::string> warnings;  ///< bodies that overlap each other or a collider.
};

/// Fills the bodies. `h` [m] is the grid spacing that decides how densely: the scene's, or a coarser one for
/// an estimate. Throws SceneError for a body that has no particles at the scene's, or that lies too far from
/// the origin.
StartingParticles make_particles(const LoadedScene&, double h);

}  // namespace firn
