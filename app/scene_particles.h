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
    std::vector<double> volumes;        ///< Σ m_p/ρ₀ of each body [m³].
    std::vector<std::string> warnings;  ///< bodies that overlap each other or a collider.
};

/// Fills the bodies. `h` [m] is the grid spacing that decides how densely: the scene's, or a coarser one for
/// an estimate. Throws SceneError for a body that has no particles at the scene's, or that lies too far from
/// the origin.
StartingParticles make_particles(const LoadedScene&, double h);

/// Bodies whose V⁰, as many numbers as particles, sum up to 20 % more or less than their m/ρ₀: they are as much too
/// stiff or too soft. `h` [m] is the spacing of the grid that found the V⁰.
std::vector<std::string> volume_warnings(const LoadedScene&, const std::vector<std::size_t>& counts,
                                         const std::vector<double>& volumes, const std::vector<float>& V0, double h);

}  // namespace firn
