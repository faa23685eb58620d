#include "app/commands.h"
#include "app/estimate.h"
#include "app/interrupt.h"
#include "app/particle_frames.h"
#include "app/particle_values.h"
#include "app/pipeline.h"
#include "app/resume.h"
#include "app/video.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <chrono>

namespace firn {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

static double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// A run: what the user asked for, and where it is.
struct Run {
    const RunOptions& options;
    const LoadedScene& loaded;
    FrameRange range;
    OutputFolder folder;
    Progress& progress;
    Position position;
    std::optional<FolderLock> lock;
    std::vector<std::size_t> body_particles = {};

    RunFiles files() const {
        const int columns = !options.full_state ? 6 : loaded.scene.solver.rest_speed > 0 ? 19 : 18;
        return {range.first, range.last, options.pictures, options.particles ? columns : 0};
    }
    bool in_range(int frame) const { return frame >= range.first && frame <= range.last; }
    double frame_time(int frame) const { return frame / loaded.scene.fps; }
};

static Checkpoint checkpoint_of(const Run& run, const Simulation& simulation) {
    return {program_version(), run.loaded.resolved, run.loaded.hash,  run.position.frame,
            run.position.inside, run.position.running, {}, compressed_state(simulation)};
}

// What the scene's colours show of the particles.
static std::vector<double> values_of(const Run& run, const Simulation& simulation) {
    const Scene& scene = run.loaded.scene;
    if (scene.picture.colour == Colour::snow) return {};
    const ParticleRows rows = simulation.rows(needs_full_state(scene.picture.colour));
    std::string ply = ply_header(rows);
    ply.append(reinterpret_cast<const char*>(rows.data.data()), rows.data.size());
    return particle_values(read_ply(ply), scene, run.body_particles);
}

// The state as the frame that was just reached.
static FrameJob frame_job(const Run& run, const Simulation& simulation) {
    FrameJob job;
    job.record = run.position.running;
    job.record.frame = run.position.frame;
    job.record.time = run.frame_time(run.position.frame);
    job.record.totals = simulation.totals();
    if (!run.in_range(run.position.frame)) return job;
    job.picture = run.options.pictures;
    if (job.picture) job.x = simulation.positions(), job.v = simulation.velocities();
    if (job.picture) job.values = values_of(run, simulation);
    if (run.options.particles) job.rows = simulation.rows(run.options.full_state);
    return job;
}

// One step; true if it reached the next frame.
static bool advance(Run& run, Simulation& simulation) {
    Position& at = run.position;
    const double remaining = 1 / run.loaded.scene.fps - at.inside;
    const auto start = Clock::now();
    const StepReport report = simulation.step(remaining);
    at.running.add(report, seconds_since(start));
    at.inside += report.dt;
    const bool landed = report.dt >= remaining;
    const double done = at.frame + (landed ? 1 : at.inside * run.loaded.scene.fps);
    run.progress.step(report, done, done / run.loaded.scene.fps);
    if (landed) ++at.frame, at.inside = 0;
    return landed;
}

// Simulates to the last frame, or until something stops it; leaves a checkpoint in the pipeline.
static void simulate(Run& run, Simulation& simulation, Pipeline& pipeline) {
    const auto emit = [&] {
        FrameJob job = frame_job(run, simulation);
        run.progress.frame(job.record);
        run.position.running = {};
        return pipeline.push(std::move(job));
    };
    const bool fresh = simulation.steps() == 0 && run.position.frame == 0;
    const long steps_before = simulation.steps();
    bool open = !fresh || emit();
    auto saved = Clock::now();
    double pause = 10;  // seconds between checkpoints; they may take a twentieth of the time
    while (open && run.position.frame < run.range.last && !interrupted()) {
        try {
            if (advance(run, simulation)) open = emit();
        } catch (const SimulationError&) {
            pipeline.push(checkpoint_of(run, simulation));
            throw;
        }
        if (open && seconds_since(saved) > pause) {
            const auto start = Clock::now();
            open = pipeline.push(checkpoint_of(run, simulation));
            pause = std::max(10.0, 20 * seconds_since(start));
            saved = Clock::now();
        }
    }
    if (open && (fresh || simulation.steps() > steps_before)) pipeline.push(checkpoint_of(run, simulation));
}

static RunRecord new_record(const Run& run, std::size_t particles) {
    const LoadedScene& loaded = run.loaded;
    return {loaded.resolved, loaded.hash,        loaded.scene.seed, omp_get_max_threads(), {},
            particles,       run.body_particles, {}};
}

static FrameRange checked_range(const RunOptions& options, const Scene& scene) {
    const FrameRange range = options.frames.value_or(FrameRange{0, scene.frames});
    if (range.last > scene.frames)
        throw UsageError(fmt::format("--frames {}:{}: the scene has frames 0 to {}", range.first, range.last,
                                     scene.frames));
    return range;
}

static void check_output(const RunOptions& options, const OutputFolder& folder) {
    if (fs::exists(folder.path) && !fs::is_directory(folder.path))
        throw FileError(fmt::format("cannot write into {}: it is not a folder", folder.path.string()));
    if (!options.resume && !options.overwrite && folder.has_results())
        throw UsageError(
            fmt::format("{} holds the output of a run: go on with --resume, replace it with --overwrite, or "
                        "choose another with -o",
                        folder.path.string()));
}

static Troubles troubles_of(const RunRecord& record) {
    Troubles all;
    for (const auto& r : record.frames) all.steps += r.steps, all.rejected += r.rejected, all.unconverged += r.unconverged;
    return all;
}

static std::string summary(const Run& run, const RunRecord& record) {
    double simulating = 0, drawing = 0, encoding = 0;
    for (const auto& r : record.frames)
        simulating += r.simulate_seconds, drawing += r.render_seconds, encoding += r.encode_seconds;
    const char* const kind = run.options.pictures ? "frames" : "particles";
    return fmt::format("frames {} to {} are in {} (simulating {}, drawing {}, encoding {}){}", run.range.first,
                       run.range.last, (run.folder.path / kind).string(), duration(simulating),
                       duration(drawing), duration(encoding), troubles_of(record).text());
}

static int finish(const Run& run, const Pipeline& pipeline) {
    run.progress.end();
    if (const int signal = interrupted(); signal != 0 && run.position.frame < run.range.last) {
        run.progress.warning(
            fmt::format("interrupted after frame {}; go on with --resume", run.position.frame));
        return 128 + signal;
    }
    if (!run.options.video.empty())
        make_video(run.folder, run.range.first, run.range.last, run.loaded.scene.fps, run.options.video);
    run.progress.note(summary(run, pipeline.record()));
    for (const auto& warning : troubles_of(pipeline.record()).warnings()) run.progress.warning(warning);
    return 0;
}

// What was kept stands behind the reason for which a run failed.
static std::string with_what_is_kept(const std::string& reason, const Run& run) {
    const bool any = fs::exists(run.folder.checkpoint());
    return fmt::format("{}\nkept in {}: the frames that are there, each whole{}", reason,
                       run.folder.path.string(), any ? ", and a checkpoint from which --resume goes on" : "");
}

// The particles, once it is known that memory and disk hold what comes of them.
static std::unique_ptr<Simulation> start_simulation(Run& run) {
    const Scene& scene = run.loaded.scene;
    require_resources_for_count(run.loaded, run.files(), run.folder.path);
    StartingParticles start = make_particles(run.loaded, scene.grid_spacing);
    for (const auto& warning : start.warnings) run.progress.warning(warning);
    run.body_particles = start.counts;
    const std::size_t nodes = count_nodes(start.particles, scene.grid_spacing, scene.solver.weights);
    const Needs needs = needs_of(run.loaded, static_cast<double>(start.particles.size()),
                                 static_cast<double>(nodes), run.files());
    require_resources(run.loaded, needs, run.folder.path);
    auto simulation = make_simulation(make_setup(scene), std::move(start.particles));
    for (const auto& warning : volume_warnings(run.loaded, start.counts, start.volumes, simulation->volumes(), scene.grid_spacing))
        run.progress.warning(warning);
    return simulation;
}

static void prepare_folder(Run& run) {
    make_folder(run.folder.path);
    if (!run.lock) run.lock.emplace(run.folder.path);
    if (run.options.overwrite) run.folder.remove_results();
    run.folder.remove_unfinished();
    if (run.options.pictures) make_folder(run.folder.path / "frames");
    if (run.options.particles) make_folder(run.folder.path / "particles");
}

static int execute(Run& run) {
    const auto simulation = start_simulation(run);
    RunRecord record = new_record(run, simulation->size());
    Resumption from;
    if (run.options.resume) from = resume(run.loaded, run.folder, run.options, run.range);
    for (const auto& note : from.notes) run.progress.note(note);
    if (!from.state.empty()) restore_state(*simulation, from.state);
    run.position = from.position;
    record.frames = from.frames;

    Pipeline pipeline(run.loaded.scene, run.folder, record, run.options.pictures);
    prepare_folder(run);
    run.progress.begin(run.position.frame + run.position.inside * run.loaded.scene.fps, run.range.last);
    try {
        for (const int frame : from.redraw)
            pipeline.push(job_from_particles(run.folder, record, record.frame(frame), run.loaded.scene));
        simulate(run, *simulation, pipeline);
        pipeline.finish();
    } catch (const SimulationError& e) {
        pipeline.finish();
        throw SimulationError(with_what_is_kept(e.what(), run));
    } catch (const FileError& e) {
        throw FileError(with_what_is_kept(e.what(), run));
    }
    return finish(run, pipeline);
}

int run_command(const RunOptions& options) {
    catch_interrupts();
    const LoadedScene loaded = load_scene(options.scene, options.overrides);
    const FrameRange range = checked_range(options, loaded.scene);
    const OutputFolder folder{options.output.empty() ? fs::path("out") / loaded.name
                                                     : fs::path(options.output)};
    if (!options.video.empty()) require_ffmpeg();
    check_output(options, folder);
    Progress progress(options.progress);
    Run run{options, loaded, range, folder, progress, {}, {}};
    if (fs::is_directory(folder.path)) run.lock.emplace(folder.path);
    return execute(run);
}

}  // namespace firn
