#include "app/commands.h"
#include "app/estimate.h"
#include "app/files.h"
#include "app/interrupt.h"
#include "app/particle_frames.h"
#include "app/resume.h"
#include "app/video.h"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>

namespace firn {

namespace fs = std::filesystem;

// What is drawn, and from where.
struct RunToDraw {
    Scene scene;
    RunRecord record;
    OutputFolder folder;
};

static std::optional<RunRecord> read_run(const OutputFolder& folder) {
    if (!fs::exists(folder.run_json())) return {};
    try {
        return run_record_from(nlohmann::ordered_json::parse(read_file(folder.run_json(), SIZE_MAX)));
    } catch (const nlohmann::json::exception& e) {
        throw SceneError(fmt::format("{} is not what firn writes: {}", folder.run_json().string(), e.what()));
    }
}

static RunToDraw drawing_of_folder(const RunOptions& options) {
    if (!options.output.empty() || !options.overrides.preset.empty() || !options.overrides.settings.empty())
        throw UsageError(
            "-o, --preset and --set go with a scene; to draw a folder differently: firn render SCENE.yaml -o "
            "OUT");
    const OutputFolder folder{options.scene};
    auto record = read_run(folder);
    if (!record)
        throw UsageError(fmt::format("{} has no run.json; name the scene: firn render SCENE.yaml -o {}",
                                     options.scene, options.scene));
    return {read_resolved(record->scene, folder.run_json().string()), *record, folder};
}

// The keys that changed since the particles were made and that pictures cannot follow.
static std::vector<std::string> unfollowed(const nlohmann::ordered_json& made,
                                           const nlohmann::ordered_json& now) {
    auto keys = differing_keys(made, now);
    std::erase_if(keys, [](const std::string& key) {
        return key == "title" || key == "frames" || key.starts_with("camera") || key.starts_with("picture");
    });
    return keys;
}

static RunToDraw drawing_of_scene(const RunOptions& options, Progress& progress) {
    const LoadedScene loaded = load_scene(options.scene, options.overrides);
    const OutputFolder folder{options.output.empty() ? fs::path("out") / loaded.name
                                                     : fs::path(options.output)};
    RunRecord record;
    if (const auto before = read_run(folder)) {
        record = *before;
        if (const auto keys = unfollowed(before->scene, loaded.resolved); !keys.empty())
            progress.warning(fmt::format("{}: warning: the particles in {} were made with other values of {}",
                                         options.scene, folder.path.string(), join(keys)));
    }
    record.scene = loaded.resolved, record.scene_hash = loaded.hash, record.seed = loaded.scene.seed;
    record.threads = omp_get_max_threads();
    return {loaded.scene, record, folder};
}

static std::vector<int> frames_to_draw(const RunOptions& options, const OutputFolder& folder,
                                       const std::string& scene_hash) {
    std::vector<int> frames = folder.particles_there();
    if (frames.empty())
        throw UsageError(fmt::format("no particles in {}; firn simulate makes them",
                                     (folder.path / "particles").string()));
    if (options.frames) {
        for (int frame = options.frames->first; frame <= options.frames->last; ++frame)
            if (!std::binary_search(frames.begin(), frames.end(), frame))
                throw UsageError(fmt::format("there are no particles of frame {}: {} is missing", frame,
                                             folder.particles(frame).string()));
        std::erase_if(frames, [&](int f) { return f < options.frames->first || f > options.frames->last; });
    }
    const auto drawn = [&](int frame) { return fs::exists(folder.picture(frame)); };
    if (!options.resume && !options.overwrite && std::any_of(frames.begin(), frames.end(), drawn))
        throw UsageError(
            fmt::format("{} holds pictures: draw what is missing with --resume, or all with --overwrite",
                        (folder.path / "frames").string()));
    if (options.resume)
        std::erase_if(frames, [&](int f) { return has_picture(folder, f, scene_hash); });
    return frames;
}

static void draw(Pipeline& pipeline, RunToDraw& drawing, const std::vector<int>& frames, Progress& progress) {
    for (std::size_t i = 0; i < frames.size() && !interrupted(); ++i) {
        FrameRecord record = drawing.record.frame(frames[i]);
        record.time = frames[i] / drawing.scene.fps;
        FrameJob job = job_from_particles(drawing.folder, drawing.record, record, drawing.scene);
        drawing.record.particles = job.x.size() / 3;
        if (!pipeline.push(std::move(job))) return;
        progress.picture(static_cast<int>(i) + 1);
    }
}

int render_command(const RunOptions& options) {
    catch_interrupts();
    Progress progress(options.progress);
    if (!options.video.empty()) require_ffmpeg();
    RunToDraw drawing =
        fs::is_directory(options.scene) ? drawing_of_folder(options) : drawing_of_scene(options, progress);
    if (!fs::is_directory(drawing.folder.path))
        throw UsageError(
            fmt::format("no folder {}; firn simulate makes particles to draw", drawing.folder.path.string()));
    const FolderLock lock(drawing.folder.path);
    const auto frames = frames_to_draw(options, drawing.folder, drawing.record.scene_hash);
    const auto all = drawing.folder.particles_there();

    require_picture_memory(drawing.scene.picture, options.scene, 0);
    Pipeline pipeline(drawing.scene, drawing.folder, drawing.record, true);
    make_folder(drawing.folder.path / "frames");
    drawing.folder.remove_unfinished();
    progress.begin(0, static_cast<int>(frames.size()));
    draw(pipeline, drawing, frames, progress);
    pipeline.finish();
    progress.end();
    if (const int signal = interrupted()) {
        progress.warning("interrupted; draw the rest with --resume");
        return 128 + signal;
    }
    const FrameRange range = options.frames.value_or(FrameRange{all.front(), all.back()});
    if (!options.video.empty())
        make_video(drawing.folder, range.first, range.last, drawing.scene.fps, options.video);
    progress.note(
        fmt::format("{} pictures drawn in {}", frames.size(), (drawing.folder.path / "frames").string()));
    return 0;
}

}  // namespace firn
