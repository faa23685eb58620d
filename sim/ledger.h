#pragma once
#include "sim/types.h"

#include <vector>

namespace firn {

/// Where the snow's energy went [J], gains positive. The sum of the rows is the change of kinetic + elastic.
struct Ledger {
    double gravity = 0;         ///< Σ m g·v̄ Δt: its work.
    double to_grid = 0;         ///< step 1: what averaging velocities at the nodes takes (APIC: less what C gives).
    double integration = 0;     ///< steps 3, 4, 6, 7: kinetic energy that stresses gave, and Ψ_trial − Ψⁿ; 0 for Δt → 0.
    double contact = 0;         ///< steps 5 and 9: what bodies take, or give where they move.
    double plastic = 0;         ///< step 7: Ψ − Ψ_trial, what the return mapping takes.
    double to_particles = 0;    ///< step 8: what particles have beyond the nodes, less what damping takes.
    double sleep = 0;           ///< what falls asleep stops.
    double removed = 0, added = 0;  ///< with particles that leave or come.

    double sum() const { return gravity + to_grid + integration + contact + plastic + to_particles + sleep + removed + added; }
    Ledger& operator+=(const Ledger& b) {
        gravity += b.gravity, to_grid += b.to_grid, integration += b.integration, contact += b.contact, plastic += b.plastic;
        to_particles += b.to_particles, sleep += b.sleep, removed += b.removed, added += b.added;
        return *this;
    }
};

/// What passed between snow and one body.
struct Exchange {
    Vec3d velocity{0, 0, 0};    ///< of the body [m/s]
    Vec3d impulse{0, 0, 0};     ///< of the snow on the body [N s]
    double work = 0;            ///< of the body, which moves, on the snow [J]
    Exchange& operator+=(const Exchange& b) {
        velocity = b.velocity, impulse += b.impulse, work += b.work;
        return *this;
    }
};

}  // namespace firn
