#pragma once
#include "app/checkpoint.h"
#include "app/output_folder.h"
#include "app/queue.h"
#include "render/renderer.h"

#include <chrono>
#include <exception>
#include <future>
#include <thread>
#include <variant>

namespace firn {

/// A frame on its way from the simulation to its files.
struct FrameJob {
    FrameRecord record;
    bool picture = false;               ///< draw x and v [m, m/s], 3n each.
    std::vector<float> x, v;
    std::vector<double> values;         ///< what the scene's colours show, or empty.
    std::optional<ParticleRows> rows;   ///< write these as a PLY.
    Image image;                        ///< once drawn.
};

using Job = std::variant<FrameJob, Checkpoint>;

/// Draws frames in one thread and encodes and writes them in another, in the order in which they are handed
/// in, while the simulation goes on. A checkpoint is written after all frames that were handed in before it.
class Pipeline {
public:
    /// `pictures`: with a renderer. Returns once OpenGL is found to work, or throws GLError. Writes nothing
    /// yet.
    Pipeline(const Scene&, OutputFolder, RunRecord, bool pictures);
    ~Pipeline();

    /// False if something failed; finish() then tells what.
    bool push(Job&&);

    /// Waits until all is written, run.json last. Throws what went wrong first in any thread.
    void finish();

    const RunRecord& record() const { return record_; }  ///< After finish().

private:
    void draw_all(std::promise<std::string> opened);
    void draw(FrameJob&, Renderer&) const;
    void write_all();
    void write(FrameJob&);
    void write_run_json();
    void fail(std::exception_ptr);

    const Scene scene_;
    const OutputFolder folder_;
    RunRecord record_;
    const float spacing_;
    Queue<Job> to_draw_{2}, to_write_{2};
    std::mutex error_mutex_;
    std::exception_ptr error_;
    std::chrono::steady_clock::time_point json_written_{};
    double json_pause_ = 1;     // seconds between writes; they may take a twentieth of the time
    std::thread drawer_, writer_;
};

}  // namespace firn
