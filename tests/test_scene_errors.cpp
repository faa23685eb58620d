#include "app/scene_load.h"

#include <catch2/catch.hpp>

using namespace firn;

// What a scene's text is refused with; empty if it is accepted.
static std::string refusal(const std::string& text, const Overrides& overrides = {}) {
    try {
        load_scene_text(text, "s.yaml", overrides);
        return "";
    } catch (const SceneError& e) {
        return e.what();
    }
}

static const std::string ball = "bodies: [{shape: {sphere: {radius: 0.2}}}]\n";
static const std::string rest = "grid_spacing: 0.1\n" + ball;

struct Bad {
    std::string text;
    std::string place;              // LINE:COLUMN of the error
    std::vector<std::string> says;  // parts of its message
};

static void check_refused(const std::vector<Bad>& table) {
    for (const auto& bad : table) {
        const std::string told = refusal(bad.text);
        CAPTURE(bad.text, told);
        CHECK(told.starts_with("s.yaml:" + bad.place + ": "));
        for (const auto& part : bad.says) CHECK(told.find(part) != std::string::npos);
        CHECK(told.find('\n') == std::string::npos);
    }
}

TEST_CASE("A number that is not plain, finite and in range is refused where it stands", "[scene]") {
    check_refused({
        {rest + "fps: five\n", "3:6", {"fps: five is not a number", "above 0"}},
        {rest + "fps: \"24\"\n", "3:6", {"fps: \"24\" is a text", "without quotes"}},
        {rest + "fps: '24'\n", "3:6", {"without quotes"}},
        {rest + "fps: 5kg\n", "3:6", {"write 5 alone"}},
        {rest + "fps: 1,5\n", "3:6", {"decimal point"}},
        {rest + "fps: 1_000\n", "3:6", {"underscore"}},
        {rest + "fps: 010\n", "3:6", {"octal"}},
        {rest + "fps: 0x1F\n", "3:6", {"decimal"}},
        {rest + "fps: 0o17\n", "3:6", {"decimal"}},
        {rest + "fps: .nan\n", "3:6", {"must be finite"}},
        {rest + "fps: .inf\n", "3:6", {"must be finite"}},
        {rest + "fps: -.Inf\n", "3:6", {"must be finite"}},
        {rest + "fps: nan\n", "3:6", {"must be finite"}},
        {rest + "fps: 1e999\n", "3:6", {"must be finite"}},
        {rest + "fps: 1e-400\n", "3:6", {"too near to 0"}},
        {rest + "fps: 0\n", "3:6", {"0 is out of range", "above 0, at most 1000000 [1/s]"}},
        {rest + "fps: 1e9\n", "3:6", {"out of range"}},
        {rest + "fps: yes\n", "3:6", {"not a number"}},
        {rest + "fps: [24]\n", "3:6", {"is a list; must be a number"}},
        {rest + "fps: {a: 1}\n", "3:6", {"is a mapping; must be a number"}},
        {rest + "fps:\n", "3:1", {"fps: has no value"}},
        {rest + "fps: ~\n", "3:1", {"fps: has no value"}},
        {rest + "frames: 1.5\n", "3:9", {"not a whole number"}},
        {rest + "frames: -1\n", "3:9", {"out of range; must be at least 0"}},
        {rest + "frames: 99999999999999999999\n", "3:9", {"out of range"}},
        {rest + "frames: 4294967296\n", "3:9", {"out of range"}},
        {rest + "seed: 9007199254740993\n", "3:7", {"out of range"}},
        {"grid_spacing: -0.02\n" + ball, "1:15", {"grid_spacing: -0.02 is out of range"}},
        {"grid_spacing: 0\n" + ball, "1:15", {"at least 1e-06, at most 1000 [m]"}},
        {"grid_spacing: 1e-7\n" + ball, "1:15", {"out of range"}},
    });
}

TEST_CASE("Each key keeps to its physical range", "[scene]") {
    const auto material = [](const std::string& key) { return rest + "materials: {snow: {" + key + "}}\n"; };
    check_refused({
        {material("nu: 0.5"),
         "3:24",
         {"materials.snow.nu: 0.5 is out of range; must be above -1, below 0.5"}},
        {material("nu: -1"), "3:24", {"out of range"}},
        {material("E: 0"), "3:23", {"above 0, at most 1000000000000 [Pa]"}},
        {material("E: 2e12"), "3:23", {"out of range"}},
        {material("xi: -1"), "3:24", {"at least 0"}},
        {material("theta_c: 1"), "3:29", {"at least 0, below 1"}},
        {material("theta_s: -1e-9"), "3:29", {"at least 0"}},
        {material("rho: 0"), "3:25", {"above 0"}},
        {rest + "solver: {beta: 0}\n", "3:16", {"solver.beta", "above 0, at most 1"}},
        {rest + "solver: {beta: 1.1}\n", "3:16", {"out of range"}},
        {rest + "solver: {dt: 0}\n", "3:14", {"solver.dt: 0 is out of range"}},
        {rest + "solver: {dt: soon}\n", "3:14", {"allowed: auto, or a number"}},
        {rest + "solver: {max_dt: -1}\n", "3:18", {"above 0"}},
        {rest + "solver: {flip_blend: 1.01}\n", "3:22", {"at least 0, at most 1"}},
        {rest + "solver: {tolerance: 1}\n", "3:21", {"below 1"}},
        {rest + "solver: {max_iterations: 0}\n", "3:26", {"at least 1"}},
        {rest + "picture: {width: 0}\n", "3:18", {"at least 1, at most 16384"}},
        {rest + "picture: {height: 16385}\n", "3:19", {"at most 16384"}},
        {rest + "camera: {field_of_view: 180}\n", "3:25", {"above 0, below 180"}},
        {rest + "camera: {eye: [1, 2, 3], target: [1, 2, 3]}\n",
         "3:9",
         {"camera: eye and target are the same point"}},
        {rest + "colliders: [{shape: {plane: {}}, friction: -0.1}]\n", "3:44", {"colliders.0.friction"}},
        {"grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 0}}}]\n",
         "2:36",
         {"bodies.0.shape.sphere.radius"}},
        {"grid_spacing: 0.1\nbodies: [{shape: {box: {size: [1, 0, 1]}}}]\n",
         "2:35",
         {"box.size.1", "above 0"}},
        {"grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 1}}, particles_per_cell: 2000}]\n",
         "2:61",
         {"at most 1000"}},
    });
}

TEST_CASE("A picture that no buffer holds is refused where its size stands", "[scene]") {
    check_refused({
        {rest + "picture:\n  width: 8193\n", "4:10", {"picture.width: 8193 pixels", "at most 8192", "quality: preview"}},
        {rest + "picture: {height: 16384, quality: final}\n", "3:19", {"picture.height: 16384 pixels"}},
        {rest + "picture: {height: 16385, quality: preview}\n", "3:19", {"out of range"}},
    });
    CHECK(refusal(rest + "picture: {width: 8192}\n").empty());
    CHECK(refusal(rest + "picture: {width: 16384, height: 16384, quality: preview}\n").empty());
}

TEST_CASE("Vectors, texts and words are told what they must be", "[scene]") {
    check_refused({
        {rest + "gravity: [0, -9.81]\n",
         "3:10",
         {"gravity: has 2 entries; must be a list of 3 numbers [m/s^2]"}},
        {rest + "gravity: [0, 0, 0, 0]\n", "3:10", {"has 4 entries"}},
        {rest + "gravity: [0, down, 0]\n", "3:14", {"gravity.1: down is not a number"}},
        {rest + "gravity: -9.81\n", "3:10", {"must be a list of 3 numbers"}},
        {rest + "title: 5\n", "3:8", {"write \"5\""}},
        {rest + "title: true\n", "3:8", {"must be a text"}},
        {rest + "title: [a]\n", "3:8", {"is a list; must be a text"}},
        {rest + "title: \"a\\0b\"\n", "3:8", {"control character"}},
        {rest + "solver: {weights: qubic}\n",
         "3:19",
         {"unknown word qubic; allowed: cubic, quadratic (did you mean cubic?)"}},
        {rest + "solver: {integrator: newtn}\n", "3:22", {"allowed: explicit, semi_implicit, newton", "newton"}},
        {rest + "solver: 5\n", "3:9", {"solver: is 5; must be a mapping with: defaults, integrator"}},
        {rest + "colliders: {shape: 1}\n", "3:12", {"must be a list"}},
        {rest + "materials: [a]\n", "3:12", {"must be a mapping of names"}},
        {rest + "materials: {a.b: {}}\n", "3:13", {"a name must be"}},
    });
}

TEST_CASE("Keys that are unknown, misplaced, missing or doubled are told with the right word", "[scene]") {
    check_refused({
        {"grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 1, centre: [0, 0, 0]}}}]\n",
         "2:39",
         {"bodies.0.shape.sphere.centre: unknown key; allowed: center, radius (did you mean center?)"}},
        {rest + "frmaes: 3\n", "3:1", {"frmaes: unknown key", "did you mean frames?"}},
        {rest + "xyzzyplugh: 3\n", "3:1", {"allowed: title, frames"}},
        {rest + "beta: 1\n", "3:1", {"it belongs in solver"}},
        {rest + "solver: {fps: 3}\n", "3:10", {"it belongs at the top level"}},
        {rest + "camera: {width: 3}\n", "3:10", {"it belongs in picture"}},
        {"# a scene\ntitle: x\n" + ball, "2:1", {"grid_spacing: is missing"}},
        {"grid_spacing: 0.1\n", "1:1", {"bodies: is missing"}},
        {"grid_spacing: 0.1\nbodies:\n  - velocity: [0, 0, 0]\n",
         "3:5",
         {"bodies.0.shape: is missing; a body needs shape or particles"}},
        {"grid_spacing: 0.1\nbodies: [{shape: {sphere: {}}}]\n", "2:27", {"sphere.radius: is missing"}},
        {"grid_spacing: 0.1\nbodies: []\n", "2:9", {"is empty"}},
        {rest + "fps: 24\nfps: 25\n", "4:1", {"fps: is given twice, in line 3 and in line 4"}},
        {rest + "solver:\n  beta: 1\n  dt: auto\n  beta: 1\n",
         "6:3",
         {"solver.beta: is given twice, in line 4 and in line 6"}},
        {rest + "materials: {a: {}, a: {}}\n", "3:20", {"materials.a: is given twice"}},
    });
}

TEST_CASE("A shape must be one that can stand there", "[scene]") {
    const auto body = [](const std::string& shape) {
        return "grid_spacing: 0.1\nbodies: [{shape: " + shape + "}]\n";
    };
    const auto collider = [](const std::string& shape) {
        return rest + "colliders: [{shape: " + shape + "}]\n";
    };
    check_refused({
        {body("{plane: {}}"), "2:19", {"bodies.0.shape.plane", "has no end", "allowed: sphere, box"}},
        {body("{union: [{plane: {}}]}"), "2:28", {"bodies.0.shape.union.0.plane", "has no end"}},
        {body("{difference: [{plane: {}}, {sphere: {radius: 1}}]}"), "2:33", {"has no end"}},
        {body("{spere: {radius: 1}}"), "2:19", {"unknown kind of shape", "did you mean sphere?"}},
        {body("{sphere: {radius: 1}, box: {size: [1, 1, 1]}}"), "2:18", {"has 2 kinds"}},
        {body("{}"), "2:18", {"has 0 kinds"}},
        {body("sphere"), "2:18", {"must be a mapping with one of: sphere"}},
        {body("{union: []}"), "2:26", {"one at least"}},
        {body("{cylinder: {from: [0, 0, 0], to: [0, 0, 0], radius: 1}}"), "2:29", {"the same point"}},
        {body("{sphere: {radius: 1}}, lumps: {size: 0.3, core: 1.2, seam: 1.1}"), "2:48", {"seam is less than core"}},
        {collider("{ellipsoid: {radii: [1, 1, 1]}}"),
         "3:22",
         {"cannot be a collider; allowed: sphere, plane, box, cylinder, capsule"}},
        {collider("{union: [{sphere: {radius: 1}}]}"), "3:22", {"cannot be a collider"}},
        {collider("{plane: {normal: [0, 0, 0]}}"), "3:29", {"the normal is 0"}},
    });
    CHECK(refusal(body("{difference: [{sphere: {radius: 1}}, {plane: {}}]}")) == "");
}

TEST_CASE("What is no single plain YAML document is refused", "[scene]") {
    std::string bomb = "a: &a [x,x,x,x,x,x,x,x,x]\n";
    for (char c = 'b'; c < 'k'; ++c) {
        bomb += std::string(1, c) + ": &" + c + " [";
        for (int i = 0; i < 9; ++i) bomb += std::string(i ? ",*" : "*") + static_cast<char>(c - 1);
        bomb += "]\n";
    }
    check_refused({
        {"", "1:1", {"the scene is empty"}},
        {"# nothing\n\n", "1:1", {"the scene is empty"}},
        {"- a\n", "1:1", {"the scene is a list; it must be a mapping"}},
        {"snow", "1:1", {"it must be a mapping"}},
        {rest + "---\nfps: 3\n", "3:1", {"second document"}},
        {rest + "...\nfps: 3\n", "4:1", {"second document"}},
        {rest + "a: *b\n", "3:4", {"refers to nothing"}},
        {"a: &a [*a]\n", "1:8", {"inside what it refers to"}},
        {"a: &a {b: *a}\n", "1:11", {"inside what it refers to"}},
        {rest + "<<: {fps: 3}\n", "3:1", {"merge keys"}},
        {rest + "title: !!str 5\n", "3:8", {"tags"}},
        {rest + "title: !!python/object x\n", "3:8", {"tags"}},
        {rest + "? [a, b]\n: 3\n", "3:3", {"a key must be a word"}},
        {rest + "title: \"never closed\n", "3:8", {"never closed"}},
        {rest + "title: \"escaped \\\"\n", "3:8", {"never closed"}},
        {rest + "title: &a \"never\n", "3:8", {"never closed"}},
        {rest + "title: 'never\n", "3:8", {"never closed"}},
        {rest + "title: [a\n", "4:1", {"not valid YAML"}},
        {rest + "title: a: b\n", "3:9", {"not valid YAML"}},
        {rest + "solver:\n\tbeta: 1\n", "4:1", {"a tab indents this line"}},
        {rest + "solver:\n \t # \t\n\t\n\t\tbeta: 1\n", "6:1", {"a tab indents this line"}},
        {std::string(1'000'000, '\t') + "\n" + rest + "fps: x\n", "4:6", {"fps: x"}},   // hours, if each tab looked for its line's end
        {"a: " + std::string(100, '[') + std::string(100, ']'), "1:67", {"nested too deeply"}},
        {"a: " + std::string(10'000, '['), "1:36", {"nested too deeply"}},
        {bomb, "5:4", {"more than 100000 values"}},
        {"title: caf\xE9\n", "1:11", {"byte 0xe9 is not UTF-8"}},
        {"title: \xED\xA0\x80\n", "1:8", {"not UTF-8"}},
        {"title: \xC0\x80\n", "1:8", {"not UTF-8"}},
        {"\xFF\xFEt\0i\0", "1:1", {"UTF-16"}},
        {std::string("t\0i\0", 4), "1:1", {"UTF-16"}},
        {std::string("title: a\0b\n", 11), "1:9", {"control character 0x00"}},
        {"title: a\x1B[31m\n", "1:9", {"control character 0x1b"}},
        {"\x89PNG\r\n\x1A\n", "1:1", {"not UTF-8"}},
    });
}

TEST_CASE("Columns count characters, not bytes", "[scene]") {
    check_refused({{rest + "{title: é, fps: x}\n", "3:1", {"not valid YAML"}}});
    check_refused({{"{title: éé, fps: x, grid_spacing: 0.1, bodies: [{shape: {sphere: {radius: 1}}}]}",
                    "1:18",
                    {"fps: x"}}});
    check_refused({{"\xEF\xBB\xBF" "fps: x\n" + rest, "1:6", {"fps: x"}}});
}

TEST_CASE("All errors of a scene are told at once, in the order of their places", "[scene]") {
    const std::string told = refusal(
        "fps: 0\nframes: x\ngrid_spacing: -1\nbodies:\n  - shape: {sphere: {radius: -1}}\n"
        "    velocity: [0, a, b]\ncolour: red\n");
    const std::vector<std::string> lines{"s.yaml:1:6: fps: ",
                                         "s.yaml:2:9: frames: ",
                                         "s.yaml:3:15: grid_spacing: ",
                                         "s.yaml:5:30: bodies.0.shape.sphere.radius: ",
                                         "s.yaml:6:19: bodies.0.velocity.1: ",
                                         "s.yaml:6:22: bodies.0.velocity.2: ",
                                         "s.yaml:7:1: colour: "};
    std::istringstream all(told);
    std::string line;
    for (const auto& start : lines) {
        REQUIRE(std::getline(all, line));
        CAPTURE(line);
        CHECK(line.starts_with(start));
    }
    CHECK_FALSE(std::getline(all, line));
}

TEST_CASE("A body's material must be there, and be named where there are several", "[scene]") {
    const auto scene = [](const std::string& materials, const std::string& name) {
        return "grid_spacing: 0.1\nmaterials: " + materials + "\nbodies: [{" + name +
               "shape: {sphere: {radius: 0.2}}}]\n";
    };
    CHECK(refusal(scene("{powder: {}, ice: {}}", "material: ice, ")) == "");
    CHECK(refusal(scene("{powder: {}}", "")) == "");
    CHECK(refusal("grid_spacing: 0.1\nbodies: [{material: snow, shape: {sphere: {radius: 0.2}}}]\n") == "");
    check_refused({
        {scene("{powder: {}, ice: {}}", ""),
         "3:10",
         {"bodies.0.material: is missing; there are several materials: ice, powder"}},
        {scene("{powder: {}, ice: {}}", "material: icy, "),
         "3:21",
         {"no such material: icy", "did you mean ice?"}},
    });
}

TEST_CASE("Errors of --set are told with their place in it", "[scene]") {
    const auto set = [](const std::vector<std::string>& settings) { return refusal(rest, {"", settings}); };
    CHECK(set({"solver.beta=0.5", "bodies.0.particles_per_cell=4"}) == "");
    CHECK(set({"bodies.0.velocity=[1, 2, 3]", "solver={dt: 1e-4}"}) == "");
    CHECK(set({"solver.beta=2"}) == "--set:1:13: solver.beta: 2 is out of range; must be above 0, at most 1");
    CHECK(set({"solver.bta=1"}).starts_with("--set:1:1: solver.bta: unknown key"));
    CHECK(set({"bodies.1.velocity=[0,0,0]"}).starts_with("--set:1:1: bodies.1: no such entry; bodies has 1"));
    CHECK(set({"bodies.x.velocity=[0,0,0]"}).starts_with("--set:1:1: bodies.x: no such entry"));
    CHECK(set({"grid_spacing.x=1"}).starts_with("--set:1:1: grid_spacing.x: no such key"));
    CHECK(set({"fps"}).starts_with("--set:1:1: fps: must be KEY=VALUE"));
    CHECK(set({"=5"}).starts_with("--set:1:1: =5: must be KEY=VALUE"));
    CHECK(set({"fps="}).starts_with("--set:1:5: fps: has no value"));
    CHECK(set({"fps=[1"}).starts_with("--set:1:"));
    CHECK(set({"presets.draft.fps=3"}).starts_with("--set:1:1: presets.draft.fps: cannot be set"));
    CHECK(set({"fps=0", "frames=-1"}).find('\n') != std::string::npos);
}
