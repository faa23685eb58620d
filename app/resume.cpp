#include "app/resume.h"

#include "app/files.h"
#include "render/png.h"

#include <fmt/format.h>

#include <algorithm>

namespace firn {

namespace fs = std::filesystem;

static void check_same_scene(const Checkpoint& checkpoint, const LoadedScene& loaded,
                             const OutputFolder& folder) {
    const std::string advice = "; resume with the same, or begin again with --overwrite";
    const std::string which = folder.checkpoint().string();
    if (checkpoint.version != program_version())
        throw UsageError(fmt::format("{} was written by firn {}; this is {}, whose steps may differ (CHANGELOG.md tells how). "
                                     "Go on with firn {}, or begin again with --overwrite; --set solver.defaults=paper takes "
                                     "the step as published, which 0.1.0 took", which, checkpoint.version,
                                     program_version(), checkpoint.version));
    if (checkpoint.scene_hash == loaded.hash) return;
    auto keys = differing_keys(checkpoint.scene, loaded.resolved);
    std::erase(keys, "frames");
    throw UsageError(fmt::format("the scene differs from that of {} in {}{}", which,
                                 keys.empty() ? "its particle files" : join(keys), advice));
}

bool has_picture(const OutputFolder& folder, int frame, const std::string& hash) {
    if (!is_whole_png(folder.picture(frame).string())) return false;
    const std::string bytes = read_file(folder.picture(frame), SIZE_MAX);
    const auto texts = png_texts({bytes.begin(), bytes.end()});
    const auto is = [&](const char* key, const std::string& value) {
        return texts.contains(key) && texts.at(key) == value;
    };
    return is("Frame", std::to_string(frame)) && is("Scene-Hash", hash);
}

// 1, 2, 3, 7 as "1 to 3, 7"
static std::string ranges(const std::vector<int>& frames) {
    std::vector<std::string> words;
    for (std::size_t i = 0; i < frames.size();) {
        std::size_t end = i;
        while (end + 1 < frames.size() && frames[end + 1] == frames[end] + 1) ++end;
        words.push_back(end == i ? fmt::format("{}", frames[i])
                                 : fmt::format("{} to {}", frames[i], frames[end]));
        i = end + 1;
    }
    return join(words);
}

static void check_files(Resumption& resumption, const OutputFolder& folder, const RunOptions& options,
                        const FrameRange& range, const std::string& hash) {
    const auto particles = folder.particles_there();
    std::vector<int> lost;
    for (int frame = range.first; frame <= std::min(range.last, resumption.position.frame); ++frame) {
        const bool has_particles = std::binary_search(particles.begin(), particles.end(), frame);
        const bool draw = options.pictures && !has_picture(folder, frame, hash);
        if (has_particles && draw) resumption.redraw.push_back(frame);
        if (!has_particles && (draw || options.particles)) lost.push_back(frame);
    }
    if (!resumption.redraw.empty())
        resumption.notes.push_back(
            fmt::format("drawing frames {} again from their particles", ranges(resumption.redraw)));
    if (!lost.empty())
        throw UsageError(
            fmt::format("frames {} are missing or not whole in {}, and lie before the checkpoint (frame {}): "
                        "put them back, go on without them (--frames {}:{}), or begin again with --overwrite",
                        ranges(lost), folder.path.string(), resumption.position.frame, lost.back() + 1,
                        std::max(range.last, lost.back() + 1)));
}

Resumption resume(const LoadedScene& loaded, const OutputFolder& folder, const RunOptions& options,
                  const FrameRange& range) {
    Resumption resumption;
    if (!fs::exists(folder.checkpoint())) {
        resumption.notes.push_back(
            fmt::format("no checkpoint in {}: starting from the beginning", folder.path.string()));
        return resumption;
    }
    Checkpoint checkpoint = read_checkpoint(folder.checkpoint());
    check_same_scene(checkpoint, loaded, folder);
    resumption.position = {checkpoint.frame, checkpoint.inside, checkpoint.running};
    resumption.frames = std::move(checkpoint.frames);
    resumption.state = std::move(checkpoint.state);
    resumption.notes.push_back(
        fmt::format("going on from frame {}{}", checkpoint.frame,
                    checkpoint.inside > 0 ? fmt::format(" and {:.3g} s", checkpoint.inside) : ""));
    check_files(resumption, folder, options, range, loaded.hash);
    return resumption;
}

}  // namespace firn
