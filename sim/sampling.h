#pragma once
#include "sim/settings.h"
#include "sim/snow.h"

#include <cstdint>
#include <vector>

namespace firn {

enum class Sampling { poisson_disk, lattice, random };

/// Snow that was packed unevenly, by hands or by weather: firm lumps with weak seams between them.
struct Lumps {
    double size = 0.05;                 ///< mean width of the largest [m]; a cell of the grid sees nothing smaller than itself.
    double core = 0.85;                 ///< J_P within the firmest [1]: exp(ξ (1 − J_P)) times as stiff, 1/J_P as dense.
    double seam = 1.2;                  ///< J_P between lumps [1].
};

/// Where particles come from: a shape that is filled with them. (A file of them is read by the program.)
struct Body {
    Shape shape;
    Vec3d velocity{0, 0, 0};            ///< [m/s]
    Vec3d angular_velocity{0, 0, 0};    ///< ω [rad/s] about the centre of mass: v = velocity + ω × (x − c).
    double particles_per_cell = 8;      ///< particles in h³ of snow [1].
    Sampling sampling = Sampling::poisson_disk;
};

/// Particles before the simulation takes them over, n of each.
struct ParticleSet {
    std::vector<Vec3d> x;               ///< [m]
    std::vector<Vec3d> v;               ///< [m/s]
    std::vector<double> m;              ///< [kg]
    std::vector<double> V0;             ///< [m³]; 0 where it is not known yet (`initial_volume` decides).
    std::vector<double> Jp;             ///< [1]
    std::vector<Mat3d> Fe;              ///< [1]
    std::vector<std::uint8_t> material; ///< index into the simulation's materials.
    std::size_t size() const { return x.size(); }
    void append(const ParticleSet&);
};

/// Fills the body with particles whose masses add up to ρ times its volume.
/// Poisson-disk: no two nearer than a radius that the seed's tile has reached (about 0.8 of the mean spacing);
/// lattice: a cubic one through the world's origin, shifted by half its spacing; random: independent points.
/// The same seed gives the same particles on every machine.
ParticleSet sample(const Body&, double rho, double h, std::uint64_t seed, std::uint8_t material);

/// How many points `sample` tries, those near the shape; counted up to about `most`.
double tries(const Body&, double h, double most);

/// How many particles `sample` will make, to about 1 %, without making them.
double expected_count(const Body&, double h);

}  // namespace firn
