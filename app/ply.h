#pragma once
#include "sim/simulation.h"

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

/// What is wrong with a particle file, without its name.
struct PlyError : std::runtime_error { using runtime_error::runtime_error; };

/// Particles as a file has them; what it does not have is empty.
struct PlyParticles {
    std::vector<Vec3d> x;        ///< [m]
    std::vector<Vec3d> v;        ///< [m/s], where vx, vy and vz are there.
    std::vector<double> mass;    ///< [kg]
    std::vector<double> volume;  ///< [m³] at the start.
    std::vector<double> Jp;      ///< [1]
    std::vector<Mat3d> Fe;       ///< [1], where all of Fe_00 … Fe_22 are there.
    std::vector<double> asleep;  ///< 1 asleep, 0 awake.
};

/// Reads the `vertex` element of any PLY: ascii, binary of either byte order, properties of any type and
/// order, other properties and elements skipped. Throws PlyError; allocates no more than the bytes can fill.
PlyParticles read_ply(std::string_view bytes);

/// The header that stands before the rows in a binary little-endian PLY.
std::string ply_header(const ParticleRows&);

}  // namespace firn
