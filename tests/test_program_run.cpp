#include "app/ply.h"
#include "render/png.h"
#include "tests/program.h"
#include "tests/run_files.h"

using Catch::Contains;
using nlohmann::ordered_json;

namespace fs = std::filesystem;

TEST_CASE("run writes frames and a record of what was run", "[run]") {
    const TempFolder folder;
    const std::string out = folder / "deep/er/out";
    const Outcome outcome =
        run_firn({"run", folder.write("ball.yaml", small_scene), "-o", out, "--threads", "2"});
    CAPTURE(outcome.err);
    REQUIRE(outcome.code == 0);
    CHECK(outcome.out == "");
    CHECK_THAT(outcome.err, Contains(out + "/frames"));

    const auto record = ordered_json::parse(bytes_of_file(out + "/run.json"));
    std::vector<std::string> keys;
    for (const auto& [key, value] : record.items()) keys.push_back(key);
    CHECK(keys == std::vector<std::string>{"program", "version", "scene", "scene_hash", "seed", "threads",
                                           "machine", "gl_renderer", "particles", "body_particles", "frames"});
    CHECK(record["program"] == "firn");
    CHECK(record["version"] == FIRN_VERSION);
    CHECK(record["scene"]["solver"]["beta"] == 0.6);
    CHECK(record["seed"] == 1);
    CHECK(record["threads"] == 2);
    CHECK(record["machine"]["memory"] > 0);
    CHECK(record["gl_renderer"].get<std::string>() != "");
    CHECK(record["particles"] > 100);
    REQUIRE(record["frames"].size() == 7);
    for (int k = 0; k <= 6; ++k) {
        const auto& frame = record["frames"][k];
        CAPTURE(k, frame);
        std::vector<std::string> frame_keys;
        for (const auto& [key, value] : frame.items()) frame_keys.push_back(key);
        CHECK(frame_keys == std::vector<std::string>{
                                "frame", "time", "steps", "dt_min", "dt_max", "solver_iterations",
                                "unconverged", "rejected", "residuals", "simulate_seconds", "render_seconds", "encode_seconds", "kinetic", "elastic",
                                "potential", "momentum", "angular_momentum", "mass", "max_density", "peak_nodes", "nodes", "stiff_nodes", "asleep",
                                "simulated", "ledger", "colliders"});
        CHECK(frame["frame"] == k);
        CHECK(frame["time"] == k / 24.0);
        CHECK(frame["mass"].get<double>() == Approx(400 * 4 / 3.0 * 3.14159265 * 0.008));
        CHECK((frame["steps"] > 0) == (k > 0));
        CHECK(frame["dt_min"] <= frame["dt_max"]);
        CHECK((frame["peak_nodes"] > 0) == (k > 0));
        CHECK(frame["render_seconds"] > 0);

        const std::string png = bytes_of_file(out + "/frames/frame_000" + std::to_string(k) + ".png");
        const auto texts = firn::png_texts({png.begin(), png.end()});
        CHECK(texts.at("Title") == "Wurf — test");
        CHECK(texts.at("Frame") == std::to_string(k));
        CHECK(std::stod(texts.at("Time")) == k / 24.0);
        CHECK(texts.at("Software") == "firn " FIRN_VERSION);
        CHECK(texts.at("Scene-Hash") == record["scene_hash"]);
    }
    std::vector<std::string> names;
    for (const auto& file : fs::directory_iterator(out)) names.push_back(file.path().filename());
    std::sort(names.begin(), names.end());
    CHECK(names == std::vector<std::string>{"checkpoint.firn", "frames", "run.json"});
}

TEST_CASE("The number of threads changes no byte", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene);
    for (const char* threads : {"1", "2", "5"})
        REQUIRE(run_firn({"run", ball, "-o", folder / threads, "--threads", threads, "--particles", "--state",
                          "full"})
                    .code == 0);
    CHECK(same_files(folder / "1", folder / "2"));
    CHECK(same_files(folder / "1", folder / "5"));
}

TEST_CASE("Output that is there is kept unless --overwrite says otherwise, and then only firn's own goes",
          "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene), out = folder / "out";
    fs::create_directory(out);
    folder.write("out/notes.txt", "mine");
    REQUIRE(run_firn({"run", ball, "-o", out}).code == 0);
    const auto before = files_of(out);
    const Outcome refused = run_firn({"run", ball, "-o", out, "--set", "frames=1"});
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains("--resume") && Contains("--overwrite"));
    CHECK((files_of(out) == before));
    REQUIRE(run_firn({"run", ball, "-o", out, "--set", "frames=1", "--overwrite"}).code == 0);
    CHECK(fs::exists(out + "/frames/frame_0001.png"));
    CHECK_FALSE(fs::exists(out + "/frames/frame_0002.png"));
    CHECK(bytes_of_file(out + "/notes.txt") == "mine");
}

TEST_CASE("simulate needs no OpenGL, and render draws from it what run draws", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene), out = folder / "out";
    Launch launch{{"simulate", ball, "-o", out}};
    launch.environment = {"__EGL_VENDOR_LIBRARY_DIRS=/nonexistent"};
    REQUIRE(run_firn(launch).code == 0);
    CHECK(ordered_json::parse(bytes_of_file(out + "/run.json"))["gl_renderer"].is_null());
    CHECK_FALSE(fs::exists(out + "/frames"));
    const std::string ply = bytes_of_file(out + "/particles/frame_0006.ply");
    CHECK_THAT(ply.substr(0, 300), Contains("property float vz\nend_header\n"));
    CHECK(firn::read_ply(ply).v.size() > 100);

    const Outcome no_gl = run_firn({.arguments = {"render", out}, .environment = launch.environment});
    CHECK(no_gl.code == 5);
    CHECK_FALSE(fs::exists(out + "/frames"));
    launch.arguments = {"run", ball, "-o", folder / "none"};
    CHECK(run_firn(launch).code == 5);
    CHECK_FALSE(fs::exists(folder / "none"));

    REQUIRE(run_firn({"render", out}).code == 0);
    REQUIRE(run_firn({"run", ball, "-o", folder / "run", "--particles"}).code == 0);
    CHECK(same_files(folder / "run", out));

    CHECK(run_firn({"render", out}).code == 2);
    fs::remove(out + "/frames/frame_0003.png");
    CHECK(run_firn({"render", out, "--resume"}).code == 0);
    CHECK(same_files(folder / "run", out));
    const std::string wide = folder.write("wide.yaml", small_scene + "camera: {field_of_view: 60}\n");
    CHECK(run_firn({"render", wide, "-o", out, "--frames", "2:3", "--overwrite"}).code == 0);
    CHECK(bytes_of_file(out + "/frames/frame_0003.png") !=
          bytes_of_file(folder / "run/frames/frame_0003.png"));
    CHECK(bytes_of_file(out + "/frames/frame_0004.png") ==
          bytes_of_file(folder / "run/frames/frame_0004.png"));
    CHECK(run_firn({"render", ball, "-o", out, "--resume"}).code == 0);  // pictures of another scene are not kept
    CHECK(same_files(folder / "run", out));
    fs::resize_file(out + "/particles/frame_0002.ply", 500);
    const Outcome torn = run_firn({"render", out, "--overwrite"});
    CHECK(torn.code == 2);
    CHECK_THAT(torn.err, Contains("frame_0002.ply"));
    auto without_camera = ordered_json::parse(bytes_of_file(out + "/run.json"));
    without_camera["scene"].erase("camera");
    const std::string right = bytes_of_file(out + "/run.json");
    for (const auto& [key, wrong] : {std::pair{"particles", ordered_json(-4.5)}, {"frames", ordered_json({{{"frame", 1e300}}})},
                                     {"body_particles", ordered_json({1e30})}, {"seed", ordered_json("one")}}) {
        CAPTURE(key);
        auto json = ordered_json::parse(right);
        json[key] = wrong;
        folder.write("out/run.json", json.dump());
        const Outcome damaged = run_firn({"render", out, "--overwrite"});
        CHECK(damaged.code == 2);
        CHECK_THAT(damaged.err, Contains("run.json is not what firn writes"));
    }
    folder.write("out/run.json", without_camera.dump());
    const Outcome blind = run_firn({"render", out, "--overwrite"});
    CHECK(blind.code == 2);
    CHECK_THAT(blind.err, Contains("run.json:") && Contains("camera: is missing"));
    CHECK(run_firn({"render", folder / "nothing"}).code == 2);
    fs::create_directory(folder / "empty");
    CHECK(run_firn({"render", folder / "empty"}).code == 2);
}

TEST_CASE("option frames writes these frames alone, the same bytes as in a whole run", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene);
    REQUIRE(run_firn({"run", ball, "-o", folder / "whole"}).code == 0);
    REQUIRE(run_firn({"run", ball, "-o", folder / "part", "--frames", "2:3"}).code == 0);
    int pictures = 0;
    for (const auto& file : fs::directory_iterator(folder / "part/frames")) {
        CHECK(bytes_of_file(file) == bytes_of_file(folder.path() / "whole/frames" / file.path().filename()));
        ++pictures;
    }
    CHECK(pictures == 2);
    CHECK_THAT(run_firn({"run", ball, "-o", folder / "beyond", "--frames", "2:7"}).err,
               Contains("the scene has frames 0 to 6"));
    CHECK_FALSE(fs::exists(folder / "beyond"));
    REQUIRE(run_firn({"run", ball, "-o", folder / "still", "--set", "frames=0"}).code == 0);
    CHECK(bytes_of_file(folder / "still/frames/frame_0000.png") ==
          bytes_of_file(folder / "whole/frames/frame_0000.png"));
}

TEST_CASE("Particles of a run start another one where it was", "[run]") {
    const TempFolder folder;
    const std::string solver =
        "solver: {precision: double, initial_volume: sampled, integrator: explicit, weights: quadratic}\n";
    const std::string body =
        "bodies: [{shape: {sphere: {center: [0, 0.22, 0], radius: 0.2}}, velocity: [1, -3, 0]}]\n";
    const std::string head =
        "grid_spacing: 0.08\nframes: 2\ncolliders: [{shape: {plane: {}}}]\npicture: {width: 64, height: "
        "36}\n" +
        solver;
    REQUIRE(run_firn({"simulate", folder.write("a.yaml", head + body), "-o", folder / "a", "--state", "full"})
                .code == 0);
    fs::copy_file(folder / "a/particles/frame_0001.ply", folder / "start.ply");
    const std::string again = folder.write("b.yaml", head + "bodies: [{particles: start.ply}]\n");
    REQUIRE(run_firn({"simulate", again, "-o", folder / "b", "--state", "full", "--set", "frames=1"}).code ==
            0);
    const auto a = firn::read_ply(bytes_of_file(folder / "a/particles/frame_0002.ply"));
    const auto b = firn::read_ply(bytes_of_file(folder / "b/particles/frame_0001.ply"));
    REQUIRE(a.x.size() == b.x.size());
    double farthest = 0;
    for (std::size_t p = 0; p < a.x.size(); ++p) farthest = std::max(farthest, (a.x[p] - b.x[p]).norm());
    CHECK(farthest < 1e-9);
}

TEST_CASE("Progress is silent with --quiet and JSON lines with --json", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene);
    const Outcome quiet = run_firn({"run", ball, "-o", folder / "quiet", "--quiet"});
    CHECK(quiet.code == 0);
    CHECK(quiet.err == "");
    const Outcome json = run_firn({"run", ball, "-o", folder / "json", "--json"});
    std::istringstream lines(json.err);
    int frames = 0;
    for (std::string line; std::getline(lines, line);) {
        const auto event = ordered_json::parse(line);
        CHECK(event["event"] == "frame");
        for (const char* key : {"frame", "last_frame", "time", "dt", "steps", "steps_per_second",
                                "iterations", "unconverged", "rejected", "seconds_left"})
            CHECK(event.contains(key));
        CHECK(event["frame"] == frames++);
    }
    CHECK(frames == 7);
    const Outcome warned = run_firn({"run", ball, "-o", folder / "warned", "--quiet", "--set",
                                     "bodies.0.shape.sphere.center=[0, 0.1, 0]"});
    CHECK_THAT(warned.err, Contains("ball.yaml:6:10: bodies.0: warning: about"));
    for (const char* command : {"check", "simulate"}) {
        Launch stiff{{command, ball, "--set", "solver.initial_volume=grid"}};
        stiff.folder = folder.path();
        CHECK_THAT(run_firn(stiff).err, Contains("ball.yaml:6:10: bodies.0: warning: its particles have"));
    }
}

TEST_CASE("Without -o the output goes to out/<scene> of the working folder", "[run]") {
    const TempFolder folder;
    folder.write("ball.yaml", small_scene);
    Launch launch{{"simulate", "ball.yaml", "--frames", "1:1"}};
    launch.folder = folder.path();
    CHECK(run_firn(launch).code == 0);
    CHECK(fs::exists(folder / "out/ball/particles/frame_0001.ply"));
    launch.arguments = {"render", "ball.yaml"};
    CHECK(run_firn(launch).code == 0);
    CHECK(fs::exists(folder / "out/ball/frames/frame_0001.png"));
}

TEST_CASE("A film holds all frames, and needs ffmpeg before anything starts", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene);
    Launch without{{"run", ball, "-o", folder / "none", "--video", folder / "a.mp4"}};
    without.environment = {"PATH=" + folder.path().string()};
    const Outcome refused = run_firn(without);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains("ffmpeg, which is not installed"));
    CHECK_FALSE(fs::exists(folder / "none"));
    if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) {
        WARN("ffmpeg is not installed: no film was made");
        return;
    }
    const Outcome film = run_firn({"run", ball, "-o", folder / "out %d", "--video", folder / "-a film.mp4",
                                   "--set", "picture.width=63"});
    CAPTURE(film.err);
    CHECK(film.code == 0);
    CHECK(fs::file_size(folder / "-a film.mp4") > 500);
    CHECK(run_firn({"render", folder / "out %d", "--video", "x"}).code == 2);
    const Outcome failed = run_firn({"run", ball, "-o", folder / "out %d", "--resume", "--set",
                                     "picture.width=63", "--video", folder / "none/a.mp4"});
    CHECK(failed.code == 4);
    CHECK_THAT(failed.err, Contains("none/a.mp4"));
}

TEST_CASE("Frame k holds the state at k / fps exactly", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", R"(grid_spacing: 0.08
frames: 6
gravity: [0, 0, 0]
solver: {integrator: explicit, weights: quadratic, precision: double, dt: 0.04164}  # of 0.041667 in a frame
materials: {snow: {E: 1}}  # so soft that the long step is stable
bodies: [{shape: {sphere: {radius: 0.2}}, velocity: [1, 0, 0]}]
)");
    REQUIRE(run_firn({"simulate", ball, "-o", folder / "out"}).code == 0);
    const auto at = [&](int frame) {
        return firn::read_ply(bytes_of_file(folder / "out/particles/frame_000" + std::to_string(frame) + ".ply"))
            .x.front()
            .x();
    };
    for (int frame = 1; frame <= 6; ++frame) CHECK(at(frame) - at(0) == Approx(frame / 24.0).epsilon(1e-12));
    const auto record = ordered_json::parse(bytes_of_file(folder / "out/run.json"));
    CHECK(record["frames"][6]["steps"] == 2);
    CHECK(record["frames"][6]["dt_max"] == 0.04164);
}
