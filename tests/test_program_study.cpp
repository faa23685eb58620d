#include "render/png.h"
#include "tests/program.h"
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>

#include <algorithm>

using Catch::Contains;

static const std::string tiny =
    "grid_spacing: 0.1\nframes: 1\nsolver: {transfer: apic}\n"
    "bodies: [{shape: {sphere: {center: [0, 0.2, 0], radius: 0.2}}, velocity: [0, -1, 0], particles_per_cell: 2}]\n"
    "colliders: [{shape: {plane: {}}}]\n";

static long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

TEST_CASE("study measures the chosen axes and names the cheapest setting below each bound", "[program]") {
    const TempFolder folder;
    const std::string scene = folder.write("tiny.yaml", tiny), out = folder / "out";
    const Outcome study = run_firn({"study", scene, "--axes", "dt,precision", "-o", out, "--threads", "1"});
    INFO(study.err);
    REQUIRE(study.code == 0);
    CHECK_THAT(study.out, Contains("Within 0.1 h (0.01 m, root mean square) of the reference"));
    CHECK(study.out == bytes_of_file(out + "/study.txt"));
    const std::string csv = bytes_of_file(out + "/study.csv");
    CHECK_THAT(csv, Catch::StartsWith("axis,setting,seconds,cpu_seconds,steps,iterations,"));
    CHECK_THAT(csv, Contains("\nreference,") && Contains("\nown,") && Contains("\nprecision,\"precision=double\","));
    CHECK_THAT(csv, !Contains("weights=") && !Contains("nan"));
    CHECK(lines(csv) == 1 + 2 + 5 + 1);
    for (const char* name : {"trade", "order"}) {
        CHECK_THAT(bytes_of_file(out + "/" + name + ".svg"), Catch::StartsWith("<svg") && Catch::EndsWith("</svg>\n"));
        CHECK(firn::read_png(out + "/" + name + ".png").width > 100);
    }
    const Outcome again = run_firn({"study", scene, "--axes", "precision", "-o", out});
    CHECK(again.code == 2);
    CHECK_THAT(again.err, Contains("--overwrite"));
    CHECK(csv == bytes_of_file(out + "/study.csv"));
}

TEST_CASE("study --stability maps every integrator", "[program]") {
    const TempFolder folder;
    const std::string scene = folder.write("tiny.yaml", tiny), out = folder / "out";
    const Outcome study = run_firn({"study", scene, "--stability", "-o", out, "--threads", "1", "--quiet", "--set",
                                    "bodies.0.particles_per_cell=0.5", "--set", "solver.weights=quadratic"});
    INFO(study.err);
    REQUIRE(study.code == 0);
    CHECK(study.err == "");
    CHECK_THAT(study.out, Contains("explicit against stiffness: ") && Contains("semi_implicit against speed: "));
    const std::string csv = bytes_of_file(out + "/stability.csv");
    CHECK_THAT(csv, Contains(",stable,") && Contains(",failed,"));
    for (const char* name : {"stability_stiffness", "stability_speed"}) {
        CHECK_THAT(bytes_of_file(out + "/" + name + ".svg"), Contains(">explicit limit<"));
        CHECK(firn::read_png(out + "/" + name + ".png").height > 100);
    }
}

TEST_CASE("study refuses what it cannot measure", "[program]") {
    const TempFolder folder;
    const std::string scene = folder.write("tiny.yaml", tiny), out = folder / "out";
    const Outcome axis = run_firn({"study", scene, "--axes", "weight", "-o", out});
    CHECK(axis.code == 2);
    CHECK_THAT(axis.err, Contains("did you mean weights?"));
    const Outcome still = run_firn({"study", scene, "--set", "frames=0", "-o", out});
    CHECK(still.code == 2);
    CHECK_THAT(still.err, Contains("frames: 0"));
    CHECK(run_firn({"study", folder / "none.yaml", "-o", out}).code == 2);
    CHECK(run_firn({"study", scene, "-o", scene}).code == 4);
    CHECK_FALSE(std::filesystem::exists(out));
}
