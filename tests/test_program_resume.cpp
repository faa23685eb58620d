#include "app/checkpoint.h"
#include "tests/program.h"
#include "tests/run_files.h"

#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <thread>

using Catch::Contains;

namespace fs = std::filesystem;

TEST_CASE("A run stopped anywhere goes on to the same bytes", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene), whole = folder / "whole";
    const std::string length = "frames=12";  // at most 7 frames are on their way to the disk
    REQUIRE(run_firn({"run", ball, "-o", whole, "--particles", "--set", length}).code == 0);
    int inside_frames = 0;
    struct Stop { int signal, frame; };
    for (const auto [signal, frame] :
         {Stop{SIGINT, 0}, Stop{SIGTERM, 2}, Stop{SIGKILL, 3}, Stop{SIGINT, 4}}) {
        const std::string out = folder / ("out" + std::to_string(signal) + "_" + std::to_string(frame));
        Launch launch{{"run", ball, "-o", out, "--particles", "--set", length}};
        launch.while_running = [&, frame = frame, signal = signal](int process) {
            const std::string awaited = out + "/frames/frame_000" + std::to_string(frame) + ".png";
            for (int tries = 0; tries < 5000 && !fs::exists(awaited); ++tries)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            ::kill(process, signal);
        };
        const Outcome first = run_firn(launch);
        CAPTURE(signal, frame, first.err);
        REQUIRE(first.code == 128 + signal);
        CHECK(fs::exists(out + "/checkpoint.firn") == (signal != SIGKILL));
        if (signal != SIGKILL) CHECK_THAT(first.err, Contains("go on with --resume"));
        const Outcome second = run_firn({"run", ball, "-o", out, "--particles", "--resume", "--set", length});
        CAPTURE(second.err);
        CHECK(second.code == 0);
        inside_frames += second.err.find(" and 0.0") != std::string::npos;
        CHECK(same_files(whole, out));
    }
    CHECK(inside_frames > 0);
}

TEST_CASE("option resume extends a run, and only the same scene's", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene), out = folder / "out";
    REQUIRE(run_firn({"run", ball, "-o", out, "--set", "frames=2"}).code == 0);
    const Outcome other =
        run_firn({"run", ball, "-o", out, "--resume", "--set", "solver.flip_blend=0.9", "--set", "seed=2"});
    CHECK(other.code == 2);
    CHECK_THAT(other.err, Contains("seed, solver.flip_blend"));
    REQUIRE(run_firn({"run", ball, "-o", out, "--resume"}).code == 0);
    REQUIRE(run_firn({"run", ball, "-o", folder / "whole"}).code == 0);
    CHECK(same_files(folder / "whole", out));
    CHECK(run_firn({"run", ball, "-o", out, "--resume"}).code == 0);
    CHECK(same_files(folder / "whole", out));

    const Outcome fresh = run_firn({"run", ball, "-o", folder / "fresh", "--resume"});
    CHECK(fresh.code == 0);
    CHECK_THAT(fresh.err, Contains("starting from the beginning"));
    CHECK(same_files(folder / "whole", folder / "fresh"));
}

TEST_CASE("option resume names the program that wrote a checkpoint, and the way to its step", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene), out = folder / "out";
    REQUIRE(run_firn({"run", ball, "-o", out, "--set", "frames=1"}).code == 0);
    firn::Checkpoint checkpoint = firn::read_checkpoint(out + "/checkpoint.firn");
    checkpoint.version = "0.1.0";
    firn::write_checkpoint(out + "/checkpoint.firn", checkpoint);
    const std::string picture = bytes_of_file(out + "/frames/frame_0001.png");
    const Outcome refused = run_firn({"run", ball, "-o", out, "--resume"});
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains("firn 0.1.0") && Contains("solver.defaults=paper") && Contains("--overwrite"));
    CHECK((bytes_of_file(out + "/frames/frame_0001.png") == picture));
}

TEST_CASE("option resume finds frames that are missing or torn, and draws them from particles where it can",
          "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene), out = folder / "out",
                      kept = folder / "kept";
    REQUIRE(run_firn({"run", ball, "-o", out}).code == 0);
    const std::string first = bytes_of_file(out + "/frames/frame_0001.png");
    fs::resize_file(out + "/frames/frame_0001.png", 50);
    fs::remove(out + "/frames/frame_0002.png");
    fs::copy_file(out + "/frames/frame_0005.png", out + "/frames/frame_0004.png",
                  fs::copy_options::overwrite_existing);
    const Outcome lost = run_firn({"run", ball, "-o", out, "--resume"});
    CHECK(lost.code == 2);
    CHECK_THAT(lost.err, Contains("frames 1 to 2, 4 are missing or not whole") && Contains("--frames 5:6"));
    CHECK(run_firn({"run", ball, "-o", out, "--resume", "--frames", "5:6"}).code == 0);

    REQUIRE(run_firn({"run", ball, "-o", kept, "--particles"}).code == 0);
    const auto before = files_of(kept);
    fs::resize_file(kept + "/frames/frame_0001.png", 50);
    fs::remove(kept + "/frames/frame_0002.png");
    const Outcome drawn = run_firn({"run", ball, "-o", kept, "--resume", "--particles"});
    CHECK(drawn.code == 0);
    CHECK_THAT(drawn.err, Contains("drawing frames 1 to 2 again"));
    CHECK((files_of(kept) == before));
}

TEST_CASE("A damaged checkpoint is told, not used", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene), out = folder / "out";
    REQUIRE(run_firn({"run", ball, "-o", out, "--set", "frames=1"}).code == 0);
    fs::resize_file(out + "/checkpoint.firn", fs::file_size(out + "/checkpoint.firn") / 2);
    const Outcome outcome = run_firn({"run", ball, "-o", out, "--resume"});
    CHECK(outcome.code == 4);
    CHECK_THAT(outcome.err, Contains("checkpoint.firn is damaged") && Contains("--overwrite"));
}

TEST_CASE("A full disk, a read-only place and a file in the way end with code 4 and whole files", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene);
    Launch limited{{"run", ball, "-o", folder / "out", "--particles", "--state", "full"}};
    limited.before_exec = [] { const rlimit small{20'000, 20'000}; setrlimit(RLIMIT_FSIZE, &small); };
    const Outcome full = run_firn(limited);
    CHECK(full.code == 4);
    CHECK_THAT(full.err, Contains("out/particles/frame_0000.ply: File too large"));
    for (const auto& file : fs::recursive_directory_iterator(folder / "out")) CHECK(file.is_directory());
    REQUIRE(run_firn({"run", ball, "-o", folder / "out", "--particles", "--resume"}).code == 0);

    folder.write("file", "");
    CHECK(run_firn({"run", ball, "-o", folder / "file"}).code == 4);
    CHECK(run_firn({"run", ball, "-o", folder / "file/out"}).code == 4);
    CHECK(run_firn({"run", ball, "-o", "/proc/firn"}).code == 4);
}

TEST_CASE("A second run in the same folder is refused while the first one works", "[run]") {
    const TempFolder folder;
    const std::string ball = folder.write("ball.yaml", small_scene + "seed: 9\n");
    Launch first{{"run", ball, "-o", folder / "out", "--set", "frames=400"}};
    Outcome second;
    first.while_running = [&](int process) {
        for (int tries = 0; tries < 500 && !fs::exists(folder / "out/frames/frame_0001.png"); ++tries)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        second = run_firn({"run", ball, "-o", folder / "out", "--overwrite"});
        ::kill(process, SIGTERM);
    };
    CHECK(run_firn(first).code == 143);
    CHECK(second.code == 4);
    CHECK_THAT(second.err, Contains("is in use: process "));
}

TEST_CASE("A second interrupt ends the program at once", "[run]") {
    const TempFolder folder;
    Launch launch{{"run", folder.write("ball.yaml", small_scene), "-o", folder / "out", "--set",
                   "frames=4000", "--set", "grid_spacing=0.02"}};
    launch.while_running = [](int process) {
        std::this_thread::sleep_for(std::chrono::milliseconds(400));
        ::kill(process, SIGINT);
        std::this_thread::sleep_for(std::chrono::microseconds(200));
        ::kill(process, SIGINT);
    };
    CHECK(run_firn(launch).code == 130);
}
