#pragma once
#include "sim/sampling.h"

namespace firn {

/// J_P at a place of lumpy snow: least deep in a lump, up to `seam` where it meets its neighbours. Lumps are the
/// Voronoi cells of scattered points [Worley 1996]; each is made of smaller ones, and those of still smaller ones, which
/// in some lumps hold together and in others come apart as easily: what breaks has pieces of many sizes.
double packed_Jp(const Lumps&, const Vec3d& x, std::uint64_t seed);

/// Packs what is there as lumps: J_P is multiplied, and where the same volume holds more, mass, and V⁰ where it is known, grow by as much.
/// What gives way first, and stays whole, is decided beforehand: the paper's chunky fracture.
void pack_in_lumps(ParticleSet&, const Lumps&, std::uint64_t seed);

}  // namespace firn
