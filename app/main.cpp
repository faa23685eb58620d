#include "app/commands.h"
#include "app/files.h"
#include "app/record.h"
#include "app/study.h"
#include "render/renderer.h"

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <new>

using namespace firn;

// What the command line says.
struct CommandLine {
    RunOptions run;
    CompareOptions compare;
    StudyOptions study;
    BenchOptions bench;
    std::vector<std::string> scenes;
    std::string frames, preset, scene_name;
    int threads = 0;
    bool schema = false, quiet = false, json = false;
};

static FrameRange parse_range(const std::string& text) {
    FrameRange range;
    const char* const end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, range.first);
    const bool colon = first.ec == std::errc() && first.ptr != end && *first.ptr == ':';
    const auto last = colon ? std::from_chars(first.ptr + 1, end, range.last) : first;
    if (!colon || last.ec != std::errc() || last.ptr != end || range.first < 0 || range.last < range.first)
        throw UsageError(
            fmt::format("--frames {}: must be FIRST:LAST, two frame numbers, both included", text));
    return range;
}

static void add_overrides(CLI::App& command, CommandLine& line) {
    command.add_option("--preset", line.run.overrides.preset, "Use the scene's preset of that name")
        ->check(CLI::IsMember({"draft", "preview", "final"}))->option_text("draft|preview|final");
    command
        .add_option("--set", line.run.overrides.settings,
                    "Change a key, as bodies.0.particles_per_cell=4; repeatable")
        ->allow_extra_args(false)
        ->option_text("KEY=VALUE");
}

static void add_run_options(CLI::App& command, CommandLine& line, const char* output_default) {
    command
        .add_option("-o,--output", line.run.output,
                    fmt::format("Output folder (default: {})", output_default))
        ->option_text("DIR")
        ->check(CLI::Validator([](std::string& s) { return s.empty() ? "is empty" : ""; }, ""));
    add_overrides(command, line);
    command.add_option("--frames", line.frames, "Write only these frames, both included")->option_text("A:B");
    auto* resume = command.add_flag("--resume", line.run.resume, "Go on where an earlier run stopped");
    command.add_flag("--overwrite", line.run.overwrite, "Replace the output of an earlier run")
        ->excludes(resume);
    command.add_option("--threads", line.threads, "Threads of the simulation (default: all)")
        ->check(CLI::Range(1, 1024))->option_text("N");
    command.add_option("--video", line.run.video, "Make a film of the pictures with ffmpeg")
        ->option_text("FILE.mp4");
    auto* quiet = command.add_flag("--quiet", line.quiet, "Tell only what is wrong");
    command.add_flag("--json", line.json, "Tell progress as JSON lines on standard error")->excludes(quiet);
}

static void add_particle_options(CLI::App& command, CommandLine& line) {
    command.add_flag("--particles", line.run.particles, "Keep a PLY file a frame");
    command.add_option("--state", "full: PLY files with every property, not only x and v")
        ->check(CLI::IsMember({"full"}))->option_text("full")
        ->each([&line](const std::string&) { line.run.full_state = line.run.particles = true; });
}

// The commands that simulate or draw.
static void add_runs(CLI::App& app, CommandLine& line) {
    auto& run = *app.add_subcommand("run", "Simulate and render a scene");
    run.add_option("SCENE", line.run.scene, "Scene file (YAML)")->required();
    add_run_options(run, line, "out/<scene>");
    add_particle_options(run, line);

    auto& simulate = *app.add_subcommand("simulate", "Simulate only: a PLY file a frame, no pictures");
    simulate.add_option("SCENE", line.run.scene, "Scene file (YAML)")->required();
    add_run_options(simulate, line, "out/<scene>");
    add_particle_options(simulate, line);

    auto& render = *app.add_subcommand("render", "Draw pictures from the particles of an earlier run");
    render
        .add_option("OUT|SCENE", line.run.scene,
                    "Output folder, drawn as it was run; or a scene, drawn as it says")
        ->required();
    add_run_options(render, line, "the folder, or out/<scene>");
}

// The commands that look at scenes and pictures.
static void add_tools(CLI::App& app, CommandLine& line) {
    auto& check = *app.add_subcommand("check", "Is a scene valid; what will it take");
    check.add_option("SCENE", line.scenes, "Scene files (YAML)")->required();
    add_overrides(check, line);
    check.add_option("--threads", line.threads, "Threads of the probe")
        ->check(CLI::Range(1, 1024))
        ->option_text("N");

    auto& compare = *app.add_subcommand("compare", "Compare two pictures, or two folders of them");
    compare.add_option("A", line.compare.a, "Picture (PNG), or folder: a run's output or its frames")
        ->required();
    compare.add_option("B", line.compare.b, "The other one")->required();
    compare.add_option("--tolerance", line.compare.tolerance,
                       "Channel difference up to which pixels count as equal, 0 to 1 (default: 0)")
        ->check(CLI::Range(0.0, 1.0))
        ->check(CLI::Validator([](std::string& s) { return std::isnan(std::stod(s)) ? "is not a number" : ""; }, ""))
        ->option_text("T");
    compare.add_option("-o,--output", line.compare.heat_map,
                       "Write a heat map (for folders: a folder of them), black equal to white 0.25 apart")
        ->option_text("FILE");
    compare.add_flag("--json", line.compare.json, "Print the numbers as JSON");

    auto& scenes = *app.add_subcommand("scenes", "The scenes that come with the program");
    scenes.add_option("NAME", line.scene_name, "Print this scene");
    scenes.add_flag("--schema", line.schema, "Print the JSON Schema of scenes, for editors");
}

static void add_study(CLI::App& app, CommandLine& line) {
    auto& study = *app.add_subcommand("study", "Measure speed against accuracy, or where steps are stable");
    study.add_option("SCENE", line.study.scene, "Scene file (YAML)")->required();
    study.add_option("-o,--output", line.study.output, "Output folder (default: out/<scene>_study)")
        ->option_text("DIR")
        ->check(CLI::Validator([](std::string& s) { return s.empty() ? "is empty" : ""; }, ""));
    add_overrides(study, line);
    auto* axes = study.add_option("--axes", line.study.axes, "What to vary (default: all): " + join(axis_names()))
                     ->delimiter(',')->allow_extra_args(false)->option_text("A,B,...");
    study.add_flag("--stability", line.study.stability,
                   "Map the time steps that are stable against stiffness and speed, for each integrator")
        ->excludes(axes);
    study.add_flag("--overwrite", line.study.overwrite, "Replace the output of an earlier study");
    study.add_option("--threads", line.threads, "Threads of the simulation (default: all)")
        ->check(CLI::Range(1, 1024))->option_text("N");
    study.add_flag("--quiet", line.study.quiet, "Tell only what is wrong, and the result");
}

static void add_bench(CLI::App& app, CommandLine& line) {
    auto& bench = *app.add_subcommand("bench", "Measure how fast a step or a picture is on this machine");
    bench.add_option("--particles", line.bench.particles, "Of the ball that hits a wall (default: 400000, with --pictures 1000000)")
        ->check(CLI::Range(1000.0, 1e8))->option_text("N");
    bench.add_option("--rounds", line.bench.rounds, "How often all is measured in turn (default: 5)")
        ->check(CLI::Range(1, 1000))->option_text("N");
    bench.add_option("--yardstick", line.bench.yardstick,
                     "Run as PROGRAM PARTICLES STEPS in each round, for a ratio; it prints its \"N ns per particle-step\"")
        ->option_text("PROGRAM");
    bench.add_flag("--pictures", line.bench.pictures, "Measure pictures of a ball and of a broken heap in all qualities instead")
        ->excludes("--yardstick");
    bench.add_option("--threads", line.threads, "Threads of the parallel cases (default: all)")
        ->check(CLI::Range(1, 1024))->option_text("N");
}

static void describe_commands(CLI::App& app, CommandLine& line) {
    app.set_version_flag("--version", "firn " + program_version());
    app.require_subcommand(1);
    app.footer("Exit codes: 0 done, 1 compare found a difference, 2 usage or scene, 3 simulation failed,\n"
               "4 files, disk or memory, 5 no OpenGL, 130 and 143 interrupted.");
    add_runs(app, line);
    add_tools(app, line);
    add_study(app, line);
    add_bench(app, line);
}

static int dispatch(const CLI::App& app, CommandLine& line) {
    if (line.threads > 0) omp_set_num_threads(line.threads);
    if (!line.frames.empty()) line.run.frames = parse_range(line.frames);
    line.run.progress = line.quiet  ? ProgressStyle::none
                        : line.json ? ProgressStyle::json
                                    : ProgressStyle::automatic;
    if (app.got_subcommand("check")) return check_command(line.scenes, line.run.overrides);
    if (app.got_subcommand("compare")) return compare_command(line.compare);
    if (app.got_subcommand("study")) {
        line.study.overrides = line.run.overrides;
        if (line.study.axes.empty()) line.study.axes = axis_names();
        return study_command(line.study);
    }
    if (app.got_subcommand("bench")) {
        if (line.bench.particles == 0) line.bench.particles = line.bench.pictures ? 1e6 : 4e5;
        return line.bench.pictures ? bench_pictures(line.bench) : bench_command(line.bench);
    }
    if (app.got_subcommand("scenes")) return scenes_command(line.scene_name, line.schema);
    if (app.got_subcommand("render")) return render_command(line.run);
    if (app.got_subcommand("simulate")) {
        if (!line.run.video.empty())
            throw UsageError("simulate makes no pictures for --video; use run, or render after it");
        line.run.pictures = false, line.run.particles = true;
    }
    return run_command(line.run);
}

// An error as it is told: text for people, an object for --json.
static int failed(const CommandLine& line, int code, const std::string& message) {
    if (line.json)
        tell_json(nlohmann::ordered_json{{"event", "error"}, {"code", code}, {"message", message}});
    else tell(message + "\n");
    return code;
}

// The first word that is no command or option, and what it may have meant; empty if all are known.
static std::string wrong_word(const CLI::App& app, const std::vector<std::string>& words) {
    const auto parsed = app.get_subcommands();
    if (parsed.empty()) {
        std::vector<std::string> commands;
        for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
            commands.push_back(command->get_name());
        if (words.empty() || words[0].starts_with("-")) return "";
        return fmt::format("no command {}; allowed: {}{}", words[0], join(commands), did_you_mean(words[0], commands));
    }
    std::vector<std::string> options;
    for (const CLI::Option* option : parsed.front()->get_options())
        for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
    for (const std::string& word : words) {
        const std::string name = word.substr(0, word.find('='));
        if (name.starts_with("--") && std::find(options.begin(), options.end(), name) == options.end())
            return fmt::format("{} has no option {}{}", parsed.front()->get_name(), name, did_you_mean(name, options));
    }
    return "";
}

static int run_program(int argc, char** argv, CommandLine& line) {
    CLI::App app{"firn: snow by the material point method, from a YAML scene to pictures", "firn"};
    describe_commands(app, line);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() != 0) {
            const std::string wrong = wrong_word(app, {argv + 1, argv + argc});
            return failed(line, 2, fmt::format("{}\nRun firn --help for help.", wrong.empty() ? e.what() : wrong));
        }
        std::ostringstream text;
        app.exit(e, text, text);
        print_result(text.str());
        return 0;
    }
    return dispatch(app, line);
}

// A closed standard stream would give its number to the next file that is opened.
static void open_standard_streams() {
    for (int stream = 0; stream < 3; ++stream)
        if (::fcntl(stream, F_GETFD) == -1 && ::open("/dev/null", stream == 0 ? O_RDONLY : O_WRONLY) < 0)
            ::_exit(4);
}

// Threads of the simulation share the cores with those that draw. libgomp lets a thread that waits for the others
// spin on its core instead of leaving it to them, which costs several times the step, and it reads how long only
// when the program starts: so it is started again with the right word.
static void wait_without_spinning(char** argv) {
    if (std::getenv("OMP_WAIT_POLICY") || std::getenv("GOMP_SPINCOUNT")) return;
    if (::setenv("GOMP_SPINCOUNT", "1000", 0) == 0) ::execv("/proc/self/exe", argv);
}

// What is large goes back to the system when it is freed. Otherwise glibc keeps up to 32 MB apiece for later, which a
// picture's buffers, each of another size, seldom fit: its peak would be a sixth higher. It takes a twentieth of a picture.
static void give_back_large_buffers() { ::mallopt(M_MMAP_THRESHOLD, 4 << 20); }

int main(int argc, char** argv) {
    wait_without_spinning(argv);
    give_back_large_buffers();
    open_standard_streams();
    ignore_write_signals();
    CommandLine line;
    try {
        return run_program(argc, argv, line);
    } catch (const SceneError& e) {
        return failed(line, 2, e.what());
    } catch (const UsageError& e) {
        return failed(line, 2, e.what());
    } catch (const std::invalid_argument& e) {
        return failed(line, 2, e.what());
    } catch (const SimulationError& e) {
        return failed(line, 3, e.what());
    } catch (const GLError& e) {
        return failed(line, 5, e.what());
    } catch (const std::bad_alloc&) {
        return failed(line, 4, "out of memory; a larger grid_spacing or fewer particles_per_cell need less");
    } catch (const std::exception& e) {
        return failed(line, 4, e.what());
    }
}
