#pragma once
#include "sim/conjugate_residual.h"
#include "sim/ledger.h"
#include "sim/sampling.h"
#include "sim/settings.h"
#include "sim/snow.h"

#include <cstddef>
#include <iosfwd>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn {

/// Everything that the method needs to know of a scene.
struct Setup {
    double h = 0;                       ///< grid spacing [m].
    Vec3d gravity{0, -9.81, 0};         ///< g [m/s²].
    Solver solver;
    std::vector<Snow> materials;        ///< at least one, at most 256.
    std::vector<Collider> colliders;
};

/// Where a step's time goes [s].
struct PhaseSeconds {
    double sort = 0;                    ///< blocks, nodes and links under the particles.
    double scatter = 0;                 ///< steps 1 and 3.
    double grid = 0;                    ///< steps 4 and 5, and the check of the step.
    double solve = 0;                   ///< step 6.
    double gather = 0;                  ///< steps 7 to 10.
};

/// What one step did.
struct StepReport {
    double dt = 0;                      ///< Δt taken [s].
    int iterations = 0;                 ///< of the linear solves; 0 for explicit steps.
    std::vector<float> residuals{};     ///< of the solve, relative to its first one, as it went on [1].
    bool converged = true;              ///< false: the last residual is above the tolerance.
    int rejected = 0;                   ///< attempts with a longer Δt that were thrown away before this one.
    std::size_t nodes = 0;              ///< grid nodes in use.
    std::size_t stiff_nodes = 0;        ///< of them, those that the solve was for.
    Ledger ledger{};                    ///< where the energy went.
    std::vector<Exchange> exchanges{};  ///< with each body.
    std::size_t asleep = 0;             ///< particles that rest after the step.
    PhaseSeconds seconds{};

    void add(const Convergence& c) { iterations += c.iterations, residuals = c.history, converged = c.converged, stiff_nodes = c.unknowns; }
};

/// Sums over all particles.
struct Totals {
    double mass = 0;                    ///< [kg]
    Vec3d momentum{0, 0, 0};            ///< Σ m v [kg m/s]
    Vec3d angular_momentum{0, 0, 0};    ///< about the origin, with the affine part under APIC [kg m²/s]
    double kinetic = 0;                 ///< Σ ½ m v² [J]
    double elastic = 0;                 ///< Σ V⁰ Ψ [J]
    double potential = 0;               ///< −Σ m g·x [J]
    double max_density = 0;             ///< of a particle, m / (V⁰ J) [kg/m³]
};

/// A number that must not be: says step, time, particle or node, its value, and what to change.
struct SimulationError : std::runtime_error { using runtime_error::runtime_error; };

/// Rows of particles in the order of sampling, `columns` values a row, little-endian as in memory.
struct ParticleRows {
    bool twofold = false;               ///< double values, else float.
    std::vector<std::string> columns;   ///< x y z vx vy vz [mass volume Jp Fe_00 Fe_01 … Fe_22 [asleep]]
    std::size_t count = 0;
    std::vector<std::byte> data;        ///< count · columns · (8 or 4) bytes.
};

/// The particles, the grid and the clock of one run. Results are the same bits for every number of threads.
class Simulation {
public:
    virtual ~Simulation() = default;

    /// One step, of at most `remaining` seconds (and exactly that many where the step that is wanted comes
    /// within 10⁻⁹ of it). Throws SimulationError, after which there is no next step.
    virtual StepReport step(double remaining) = 0;

    virtual std::size_t size() const = 0;                ///< particles.
    virtual double time() const = 0;                     ///< [s] since the start.
    virtual long steps() const = 0;                      ///< taken since the start.
    virtual Totals totals() const = 0;
    virtual std::vector<float> positions() const = 0;    ///< 3n [m], in the order of sampling.
    virtual std::vector<float> velocities() const = 0;   ///< 3n [m/s], in the order of sampling.
    virtual std::vector<float> volumes() const = 0;      ///< V⁰ [m³], in the order of sampling.
    virtual ParticleRows rows(bool full) const = 0;      ///< full: with mass, volume, J_P and F_E.

    /// The whole state, bit for bit: a simulation of the same setup that restores it goes on as this one would.
    virtual void save(std::ostream&) const = 0;
    virtual void restore(std::istream&) = 0;             ///< Throws std::runtime_error if it is not such a state.
};

/// Checks nothing: values outside the ranges of the scene file are the caller's fault.
std::unique_ptr<Simulation> make_simulation(const Setup&, ParticleSet&&);

/// Bytes that a run keeps for each particle and for each grid node.
std::size_t bytes_per_particle(const Solver&);
std::size_t bytes_per_node(const Solver&);

/// Grid nodes that these particles need, counted without making a grid.
std::size_t count_nodes(const ParticleSet&, double h, Weights);

/// Steps that `seconds` of this will take at the Δt limit of particles that fall and, explicit, pack: an estimate, since Δt
/// follows the flow.
double estimate_steps(const Setup&, const ParticleSet&, double seconds);

}  // namespace firn
