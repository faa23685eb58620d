#pragma once
#include "app/ply.h"
#include "app/scene.h"
#include "render/colour_map.h"

namespace firn {

/// Whether a colour shows more of the particles than where they are and how fast.
bool needs_full_state(Colour);

/// What the scene's `picture.colour` shows, for each particle, in SI units; none for snow's own colour.
/// `bodies`: the number of each body's particles, in order; body and stress need them
/// where there are several. Throws PlyError that names what is missing.
///   density ρ = m / (V⁰ J_E J_P), compression J_P, stress √(3/2) |dev σ| with σ = P F_Eᵀ / J_E.
std::vector<double> particle_values(const PlyParticles&, const Scene&, const std::vector<std::size_t>& bodies);

/// The ends of the colour map: as the scene gives them, else round numbers about all but a hundredth of the
/// values at either end; J_P is always centred on 1.
ColourRange colour_range(const std::vector<double>& values, const Picture&);

}  // namespace firn
