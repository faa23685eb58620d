#pragma once
#include "app/machine.h"
#include "app/scene_load.h"
#include "sim/simulation.h"

#include <optional>
#include <string>
#include <vector>

namespace firn {

/// What it took to reach a frame from the one before, and the sums over its particles.
struct FrameRecord {
    int frame = 0;
    double time = 0;                ///< frame / fps [s]
    long steps = 0;
    double dt_min = 0, dt_max = 0;  ///< [s]; 0 where there was no step.
    long solver_iterations = 0;
    long unconverged = 0;           ///< solves that did not reach their tolerance.
    long rejected = 0;              ///< steps that were thrown away and repeated with a smaller one.
    std::vector<float> residuals;   ///< of the frame's solve that ended highest, as it went on [1].
    double simulate_seconds = 0;    ///< of stepping alone.
    double render_seconds = 0;
    double encode_seconds = 0;      ///< of encoding and writing the frame's files.
    Totals totals;
    std::size_t peak_nodes = 0;
    std::size_t nodes = 0, stiff_nodes = 0;     ///< of all steps together: in use, solved for.
    double simulated = 0;           ///< time since the frame before [s].
    Ledger ledger;                  ///< where the energy went since the frame before.
    std::vector<Exchange> exchanges;    ///< with each collider since then.
    std::size_t asleep = 0;         ///< particles that rest at the frame's end.

    void add(const StepReport&, double seconds);
};

/// What went wrong in steps and solves, and how often.
struct Troubles {
    long steps = 0, rejected = 0, unconverged = 0;
    /// "; 12 of 481 steps (2.5 %) rejected, 3 of 481 solves (0.62 %) not converged", or nothing.
    std::string text() const;
    /// What to change where more than a hundredth of the steps is one or the other.
    std::vector<std::string> warnings() const;
};

/// What run.json holds.
struct RunRecord {
    nlohmann::ordered_json scene;   ///< resolved.
    std::string scene_hash;
    std::uint64_t seed = 1;
    int threads = 1;
    std::optional<std::string> gl_renderer;
    std::size_t particles = 0;
    std::vector<std::size_t> body_particles;  ///< of each body, in the order of the particles.
    std::vector<FrameRecord> frames;

    FrameRecord& frame(int number);  ///< The frame's record, made if it is not there; they stay in order.
};

/// "0.2.0"
std::string program_version();

nlohmann::ordered_json to_json(const FrameRecord&);
FrameRecord frame_record_from(const nlohmann::ordered_json&);

nlohmann::ordered_json to_json(const RunRecord&);
RunRecord run_record_from(const nlohmann::ordered_json&);

}  // namespace firn
