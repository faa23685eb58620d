#include "app/commands.h"
#include "app/files.h"
#include "render/png.h"
#include "tests/program.h"
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <regex>

using Catch::Contains;

static const std::string ball =
    "grid_spacing: 0.1\nbodies: [{shape: {sphere: {center: [0, 0.3, 0], radius: 0.2}}}]\n";

TEST_CASE("Help and version are results, wrong usage is not", "[program]") {
    const Outcome help = run_firn({"--help"});
    CHECK(help.code == 0);
    CHECK(help.err == "");
    for (const char* command : {"run", "simulate", "render", "check", "compare", "study", "bench", "scenes"}) {
        CHECK_THAT(help.out, Contains(std::string("  ") + command + " "));
        const Outcome own = run_firn({command, "--help"});
        CHECK(own.code == 0);
        CHECK_THAT(own.out, Contains("Usage"));
    }
    CHECK(run_firn({"--version"}).out == "firn " FIRN_VERSION "\n");

    const std::vector<std::vector<std::string>> wrong{{},
                                                      {"runn"},
                                                      {"study"},
                                                      {"study", "a", "--stability", "--axes", "dt"},
                                                      {"run"},
                                                      {"run", "a", "b"},
                                                      {"run", "a", "--nonsense"},
                                                      {"run", "a", "--frames", "5-2"},
                                                      {"run", "a", "--frames", "5:2"},
                                                      {"run", "a", "--frames", "1:"},
                                                      {"run", "a", "--frames", "-1:2"},
                                                      {"run", "a", "--frames", "1:2x"},
                                                      {"run", "a", "--threads", "0"},
                                                      {"run", "a", "--threads", "many"},
                                                      {"run", "a", "--preset", "fast"},
                                                      {"run", "a", "--state", "half"},
                                                      {"run", "a", "--resume", "--overwrite"},
                                                      {"run", "a", "-o", ""},
                                                      {"check"},
                                                      {"compare", "a"},
                                                      {"compare", "a", "b", "--tolerance", "-1"},
                                                      {"compare", "a", "b", "--tolerance", "nan"},
                                                      {"scenes", "no_such"},
                                                      {"bench", "--rounds", "0"},
                                                      {"bench", "--pictures", "--yardstick", "true"},
                                                      {"bench", "--particles", "1000", "--rounds", "1", "--yardstick", "true"},
                                                      {"simulate", "a", "--video", "a.mp4"}};
    for (const auto& arguments : wrong) {
        const Outcome outcome = run_firn(arguments);
        CAPTURE(arguments);
        CHECK(outcome.code == 2);
        CHECK(outcome.out == "");
        CHECK(outcome.err != "");
    }
}

TEST_CASE("a wrong word is named, with the nearest right one", "[program]") {
    CHECK_THAT(run_firn({"runn", "a"}).err, Contains("runn") && Contains("did you mean run?"));
    CHECK_THAT(run_firn({"run", "a", "--overwite"}).err, Contains("--overwite") && Contains("did you mean --overwrite?"));
}

TEST_CASE("bench measures every case, and compares with another program", "[program]") {
    const TempFolder folder;
    firn::write_file(folder / "yardstick", {"#!/bin/sh\necho 'plain: 1e3 particles, 500 ns per particle-step (1 thread)'\n"});
    REQUIRE(::chmod((folder / "yardstick").c_str(), 0700) == 0);
    const Outcome bench = run_firn({"bench", "--particles", "2000", "--rounds", "1", "--threads", "2", "--yardstick",
                                    folder / "yardstick"});
    CHECK(bench.code == 0);
    CHECK(bench.err == "");
    for (const char* name : {"explicit, quadratic", "explicit, cubic", "APIC", "double", "semi-implicit, cubic", "8 balls", "× yardstick",
                             "the yardstick: 500 ns", "APIC / FLIP"})
        CHECK_THAT(bench.out, Contains(name));
    CHECK_THAT(bench.out, !Contains("nan") && !Contains("inf"));
}

TEST_CASE("bench measures pictures in every quality", "[program]") {
    const Outcome bench = run_firn({"bench", "--pictures", "--particles", "1000", "--rounds", "1"});
    if (bench.code == 5) {
        WARN("skipped, as there is no OpenGL here");
        return;
    }
    CHECK(bench.code == 0);
    CHECK(bench.err == "");
    const std::regex row("(ball|broken heap) +(draft|preview|final) +([0-9.]+) +([0-9.]+) +([0-9.]+)");
    int rows = 0;
    for (std::sregex_iterator it(bench.out.begin(), bench.out.end(), row), end; it != end; ++it, ++rows) {
        CAPTURE(it->str());
        CHECK(std::stod((*it)[3]) > 0);
        CHECK(std::stod((*it)[4]) >= std::stod((*it)[3]));
        CHECK(std::stod((*it)[5]) > 0);
    }
    CHECK(rows == 6);
}

TEST_CASE("The scenes that come with the program are listed and printed as they are", "[program]") {
    const Outcome list = run_firn({"scenes"});
    CHECK(list.code == 0);
    CHECK_THAT(list.out, Contains("snowball_wall ") && Contains("snowball_drop "));
    const std::string folder = std::string(FIRN_SOURCE_DIR) + "/scenes/";
    CHECK((run_firn({"scenes", "snowball_wall"}).out == bytes_of_file(folder + "snowball_wall.yaml")));
    CHECK((run_firn({"scenes", "snowball_drop.yaml"}).out == bytes_of_file(folder + "snowball_drop.yaml")));
    CHECK((run_firn({"scenes", "--schema"}).out == bytes_of_file(folder + "schema.json")));
    const Outcome near = run_firn({"scenes", "snowball_wal"});
    CHECK_THAT(near.err, Contains("did you mean snowball_wall?"));
    const TempFolder folder_without;
    Launch launch{{"run", "snowball_wall.yaml"}};
    launch.folder = folder_without.path();
    CHECK_THAT(run_firn(launch).err, Contains("firn scenes snowball_wall > snowball_wall.yaml"));
}

TEST_CASE("A wrong scene is refused before anything is written", "[program]") {
    const TempFolder folder;
    const std::string bad = folder.write("bad.yaml", "grid_spacing: -1\nbodies: []\n");
    const std::string out = folder / "out";
    const std::string dark = folder.write("fifo_instead", "");
    ::unlink(dark.c_str());
    REQUIRE(::mkfifo(dark.c_str(), 0600) == 0);
    const std::vector<std::string> scenes{
        bad,
        folder / "none.yaml",
        folder.path(),
        dark,
        "/dev/zero",
        folder.write("huge.yaml", std::string(1 << 21, '#')),
        folder.write("empty_body.yaml", "grid_spacing: 1\nbodies: [{shape: {sphere: {radius: 0.01}}}]\n")};
    for (const auto& scene : scenes)
        for (const char* command : {"run", "simulate"}) {
            CAPTURE(scene, command);
            const Outcome outcome = run_firn({command, scene, "-o", out});
            CHECK(outcome.code == 2);
            CHECK(outcome.err != "");
            CHECK(outcome.out == "");
            CHECK_FALSE(std::filesystem::exists(out));
        }
    CHECK_THAT(run_firn({"run", bad}).err,
               Contains("bad.yaml:1:15: grid_spacing: ") && Contains("bad.yaml:2:9: bodies: "));
    CHECK(run_firn({"run", folder.write("good.yaml", ball), "--set", "solver.beta=2", "-o", out}).err ==
          "--set:1:13: solver.beta: 2 is out of range; must be above 0, at most 1\n");
    const Outcome json = run_firn({"run", bad, "--json", "-o", out});
    CHECK_THAT(json.err, Contains("{\"event\":\"error\",\"code\":2,") && Contains("grid_spacing"));
}

TEST_CASE("check tells what a scene takes, and refuses what memory or disk cannot hold", "[program]") {
    const TempFolder folder;
    const std::string good =
        folder.write("good.yaml", ball + "frames: 3\npicture: {width: 64, height: 36}\n");
    const Outcome fine = run_firn({"check", good});
    CHECK(fine.code == 0);
    CHECK(fine.err == "");
    for (const char* what :
         {"good.yaml: good", "particles", "grid nodes", "memory", "disk", "steps", "minutes"})
        CHECK_THAT(fine.out, Contains(what));
    const std::string bad = folder.write("bad.yaml", "grid_spacing: -1\nbodies: []\n");
    const Outcome both = run_firn({"check", bad, good});
    CHECK(both.code == 2);
    CHECK_THAT(both.out, Contains("good.yaml: good"));
    CHECK_THAT(both.err, Contains("bad.yaml:1:15"));

    for (const char* command : {"check", "run", "simulate"}) {
        CAPTURE(command);
        const std::string out = folder / "out";
        const Outcome fine_grid = run_firn({command, good, "--set", "grid_spacing=1e-6"});
        CHECK(fine_grid.code == 4);
        CHECK_THAT(fine_grid.err, Contains("of memory") && Contains("set grid_spacing to"));
        const Outcome long_run =
            run_firn({command, good, "--set", "frames=10000000", "--set", "picture.width=4000", "--set",
                      "picture.height=4000", "--set", "bodies.0.particles_per_cell=1000"});
        CHECK(long_run.code == 4);
        CHECK_THAT(long_run.err, Contains("of disk"));
    }
#ifdef __SANITIZE_ADDRESS__
    WARN("the address sanitizer needs more address space than any limit: not tried with one");
#else
    Launch limited{{"check", good}};
    limited.before_exec = [] { const rlimit small{300'000'000, 300'000'000}; setrlimit(RLIMIT_AS, &small); };
    limited.arguments.insert(limited.arguments.end(), {"--set", "grid_spacing=0.002"});
    CHECK(run_firn(limited).code == 4);
    REQUIRE(run_firn({"simulate", good, "-o", folder / "snow"}).code == 0);
    for (const char* command : {"check", "render"}) {  // where pictures alone are too large, no grid is to blame
        Launch wide{{command, good, "--set", "picture.width=8192", "--set", "picture.height=8192"}};
        if (wide.arguments[0] == "render") wide.arguments.insert(wide.arguments.end(), {"-o", folder / "snow"});
        wide.before_exec = [] { const rlimit small{2'000'000'000, 2'000'000'000}; setrlimit(RLIMIT_AS, &small); };
        const Outcome outcome = run_firn(wide);
        CAPTURE(command);
        CHECK(outcome.code == 4);
        CHECK_THAT(outcome.err, Contains("set picture.width and picture.height to less") && !Contains("grid_spacing"));
    }
#endif
}

// A picture of one colour but for one pixel.
static std::string png(std::uint8_t grey, std::uint8_t odd, int width = 8) {
    firn::Image image{width, 8, std::vector<std::uint8_t>(static_cast<std::size_t>(width) * 8 * 3, grey)};
    image.pixels[0] = odd;
    const auto bytes = firn::encode_png(image, {});
    return {bytes.begin(), bytes.end()};
}

TEST_CASE("compare finds differences between pictures and says how large they are", "[program]") {
    const TempFolder folder;
    const std::string a = folder.write("a.png", png(100, 100)),
                      b = folder.write("b.png", png(100, 151));  // 0.2 apart
    const Outcome same = run_firn({"compare", a, a});
    CHECK(same.code == 0);
    CHECK_THAT(same.out, Contains("inf") && Contains("1.000000"));
    const Outcome differ = run_firn({"compare", a, b, "-o", folder / "heat.png"});
    CHECK(differ.code == 1);
    CHECK_THAT(differ.out, Contains("0.200000"));
    CHECK(firn::read_png(folder / "heat.png").width == 8);
    CHECK(run_firn({"compare", a, b, "--tolerance", "0.21"}).code == 0);
    CHECK(run_firn({"compare", a, b, "--tolerance", "0.19"}).code == 1);
    const auto json = nlohmann::json::parse(run_firn({"compare", a, b, "--json"}).out);
    CHECK(json["total"]["max_error"].get<double>() == Approx(0.2));
    CHECK(json["total"]["share_above"].get<double>() == Approx(1.0 / 64));
    CHECK(json["pictures"].size() == 1);

    const std::string wide = folder.write("wide.png", png(1, 1, 9)),
                      torn = folder.write("torn.png", png(1, 1).substr(0, 60));
    CHECK_THAT(run_firn({"compare", a, wide}).err, Contains("8 x 8") && Contains("9 x 8"));
    for (const auto& other : {wide, torn, folder / "none.png", std::string(folder.path())}) {
        const Outcome outcome = run_firn({"compare", a, other});
        CAPTURE(other, outcome.err);
        CHECK(outcome.code == 2);
        CHECK(outcome.err != "");
        CHECK(outcome.out == "");
    }
}

TEST_CASE("compare goes through sequences frame by frame", "[program]") {
    const TempFolder folder;
    for (const char* run : {"one", "two"}) {
        std::filesystem::create_directories(folder / run + "/frames");
        for (int frame = 0; frame < 3; ++frame)
            folder.write(std::string(run) + "/frames/frame_000" + std::to_string(frame) + ".png",
                         png(100, frame == 2 && run == std::string("two") ? 102 : 100));
    }
    const Outcome outcome =
        run_firn({"compare", folder / "one", folder / "two/frames", "-o", folder / "heat"});
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.out, Contains("frame_0000.png") && Contains("frame_0002.png") && Contains("total"));
    CHECK(std::filesystem::exists(folder / "heat/frame_0001.png"));
    CHECK(run_firn({"compare", folder / "one", folder / "one"}).code == 0);
    std::filesystem::remove(folder / "two/frames/frame_0001.png");
    const Outcome gap = run_firn({"compare", folder / "one", folder / "two"});
    CHECK(gap.code == 2);
    CHECK_THAT(gap.err, Contains("two/frames/frame_0001.png"));
    std::filesystem::create_directory(folder / "empty");
    CHECK(run_firn({"compare", folder / "empty", folder / "one"}).code == 2);
}

TEST_CASE("Standard streams may be closed, broken or full", "[program]") {
    const TempFolder folder;
    Launch closed{{"scenes"}};
    closed.before_exec = [] { ::close(0), ::close(1), ::close(2); };
    CHECK(run_firn(closed).code == 0);
    Launch broken{{"scenes", "--schema"}};
    broken.before_exec = [] {
        int ends[2];
        if (::pipe(ends) == 0) ::close(ends[0]), ::dup2(ends[1], 1);
    };
    CHECK(run_firn(broken).code == 0);
    Launch full{{"scenes", "--schema"}};
    full.before_exec = [] { ::dup2(::open("/dev/full", O_WRONLY), 1); };
    const Outcome outcome = run_firn(full);
    CHECK(outcome.code == 4);
    CHECK_THAT(outcome.err, Contains("standard output"));
}
