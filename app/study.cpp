#include "app/study.h"

#include "app/commands.h"
#include "app/estimate.h"
#include "app/interrupt.h"
#include "app/scene_keys.h"

#include <fmt/format.h>

#include <algorithm>

namespace firn {

namespace fs = std::filesystem;

static fs::path prepare(const StudyOptions& options, const LoadedScene& loaded) {
    const fs::path folder = options.output.empty() ? fs::path("out") / (loaded.name + "_study") : fs::path(options.output);
    if (fs::exists(folder) && !fs::is_directory(folder))
        throw FileError(fmt::format("cannot write into {}: it is not a folder", folder.string()));
    const char* const table = options.stability ? "stability.csv" : "study.csv";
    if (!options.overwrite && fs::exists(folder / table))
        throw UsageError(fmt::format("{} holds the output of a study: replace it with --overwrite, or choose another with -o",
                                     folder.string()));
    return folder;
}

static void tell_trial(const StudyOptions& options, const Trial& t, std::size_t number, std::size_t count) {
    if (options.quiet) return;
    tell(fmt::format("{} of {}: {}: {:.3g} s, {} steps{}\n", number, count, t.name, t.seconds, t.steps,
                     t.failure.empty() ? "" : ", failed: " + t.failure));
}

// Runs the trial, which the study cannot do without.
static void require_trial(Trial& trial, const ParticleSet& start, const Span& span, const char* what) {
    run_trial(trial, start, span);
    if (!trial.failure.empty() && !interrupted())
        throw SimulationError(fmt::format("{} fails, so there is nothing to compare with: {}", what, trial.failure));
}

static int trade_study(const StudyOptions& options, const LoadedScene& loaded, const ParticleSet& start, const fs::path& folder) {
    const Span span{loaded.scene.frames, loaded.scene.fps, 1e3};
    Trial own;
    own.axis = "own", own.name = "the scene's own", own.setup = make_setup(loaded.scene);
    require_trial(own, start, span, "the scene itself");
    Trial reference = reference_trial(own.setup, own.mean_dt());
    std::vector<Trial> trials = trials_along(own.setup, options.axes, own.mean_dt());
    const std::size_t count = trials.size() + 2;
    tell_trial(options, own, 1, count);
    for (std::size_t i = 0; i < trials.size() && !interrupted(); ++i) {
        run_trial(trials[i], start, span);
        tell_trial(options, trials[i], i + 2, count);
    }
    if (!interrupted()) require_trial(reference, start, span, "the reference");
    if (interrupted()) return 128 + interrupted();
    tell_trial(options, reference, count, count);
    trials.insert(trials.begin(), own);
    make_folder(folder);
    print_result(write_study(folder, loaded, start, reference, trials));
    return 0;
}

static int stability_study(const StudyOptions& options, const LoadedScene& loaded, const ParticleSet& start, const fs::path& folder) {
    std::vector<std::vector<MapField>> maps[2];
    std::string says;
    for (const bool stiffness : {true, false})
        for (const auto& choice : choices(Integrator{})) {
            maps[stiffness].push_back(stability_fields(loaded, start, choice.value, stiffness));
            if (interrupted()) return 128 + interrupted();
            const auto& fields = maps[stiffness].back();
            const auto number = [&](MapField::Verdict v) {
                return std::count_if(fields.begin(), fields.end(), [v](const MapField& f) { return f.verdict == v; });
            };
            const std::string line = fmt::format("{} against {}: {} stable, {} lossy, {} failed\n", choice.name,
                                                 stiffness ? "stiffness" : "speed", number(MapField::Verdict::stable),
                                                 number(MapField::Verdict::lossy), number(MapField::Verdict::failed));
            if (!options.quiet) tell(line);
            says += line;
        }
    make_folder(folder);
    write_stability(folder, loaded, maps[1], maps[0]);
    print_result(says);
    return 0;
}

int study_command(const StudyOptions& options) {
    for (const auto& axis : options.axes)
        if (const auto known = axis_names(); std::find(known.begin(), known.end(), axis) == known.end())
            throw UsageError(fmt::format("--axes: no axis {}; there are: {}{}", axis, join(known), did_you_mean(axis, known)));
    catch_interrupts();
    const LoadedScene loaded = load_scene(options.scene, options.overrides);
    if (loaded.scene.frames == 0) throw UsageError("a study needs time to pass: the scene has frames: 0");
    const fs::path folder = prepare(options, loaded);
    require_resources_for_count(loaded, {}, folder);
    StartingParticles start = make_particles(loaded, loaded.scene.grid_spacing);
    for (const auto& warning : start.warnings) tell(warning + "\n");
    return options.stability ? stability_study(options, loaded, start.particles, folder)
                             : trade_study(options, loaded, start.particles, folder);
}

}  // namespace firn
