#pragma once
#include "app/scene_particles.h"

#include <filesystem>
#include <optional>

namespace firn {

/// One way to run the scene, and what came of it.
struct Trial {
    std::string axis, name;         ///< "dt", "dt=1e-3"
    Setup setup;

    double seconds = 0;             ///< of stepping alone.
    double cpu_seconds = 0;         ///< of stepping, all threads: what else the machine does hardly changes it.
    long steps = 0, iterations = 0, rejected = 0, unconverged = 0;
    double simulated = 0;           ///< time reached [s].
    std::vector<Vec3d> x;           ///< where the particles ended [m].
    double energy = 0;              ///< at the end minus at the start [J].
    double energy_made = 0;         ///< largest rise above the lowest so far [J].
    double energy_scale = 0;        ///< largest kinetic and elastic energy [J].
    std::string failure;            ///< empty: it ran to the end.

    double mean_dt() const { return steps > 0 ? simulated / static_cast<double>(steps) : 0; }
};

/// How long a trial runs.
struct Span {
    int frames = 0;                 ///< it lands on each.
    double fps = 24;                ///< [1/s]
    double blow_up = 1e300;         ///< energy above that many scales at the start is a failure.
};

/// Runs the trial from these particles; stops early, with the failure "interrupted", at a signal.
void run_trial(Trial&, const ParticleSet& start, const Span&);

/// Distances between two ends of a run [m], and how differently the mass lies on a grid.
struct Deviation {
    double root_mean_square = 0, largest = 0;
    double density = 0;             ///< Σ_i |m_i − m_i'| / Σ_i m_i on the grid's nodes: 0 alike, 2 nothing in common [1].
};
Deviation deviation(const ParticleSet& start, const std::vector<Vec3d>& x, const std::vector<Vec3d>& reference, double h);

/// The names of the axes that a study can vary.
std::vector<std::string> axis_names();

/// Trials around the scene's own values, one axis at a time. `own_dt` is the scene's mean Δt [s].
std::vector<Trial> trials_along(const Setup& own, const std::vector<std::string>& axes, double own_dt);

/// The finest: double precision, 1/16 of the scene's mean Δt, a tight solve.
Trial reference_trial(const Setup& own, double own_dt);

/// study.csv, study.txt, and trade and order as .svg and .png in the folder; returns the sentences.
std::string write_study(const std::filesystem::path& folder, const LoadedScene&, const ParticleSet& start,
                        const Trial& reference, const std::vector<Trial>& trials);

/// One field of a stability map.
struct MapField {
    enum class Verdict { stable, lossy, failed } verdict;
    Trial trial;
    double dt, along;               ///< Δt [s], and Young's modulus [Pa] or speed [m/s].
};

/// What the theory says of explicit steps: Δt ≤ limit h / c, the speed of sound c unhardened; 1.92 for cubic
/// and 1.63 for quadratic weights (the chain with lumped masses).
double explicit_limit(const Setup&);

/// Every Δt against every stiffness or speed, for one integrator. The trials' scene is run to its end.
std::vector<MapField> stability_fields(const LoadedScene&, const ParticleSet& start, Integrator, bool stiffness);

/// stability.csv, and the maps as .svg and .png.
void write_stability(const std::filesystem::path& folder, const LoadedScene&, const std::vector<std::vector<MapField>>& by_stiffness,
                     const std::vector<std::vector<MapField>>& by_speed);

/// A drawing as NAME.svg and NAME.png.
struct Drawing;
void write_drawing(const std::filesystem::path& folder, const std::string& name, const Drawing&);

}  // namespace firn
