#include "app/scene_json.h"
#include "app/scene_load.h"
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace firn;

namespace fs = std::filesystem;

TEST_CASE("scenes/schema.json is what the program writes", "[scene]") {
    INFO("regenerate it with: firn scenes --schema > scenes/schema.json");
    CHECK((bytes_of_file(fs::path(FIRN_SOURCE_DIR) / "scenes/schema.json") == scene_schema().dump(2) + "\n"));
}

TEST_CASE("Every scene that comes with the program is valid in every preset, and points to the schema",
          "[scene]") {
    int found = 0;
    for (const auto& file : fs::directory_iterator(fs::path(FIRN_SOURCE_DIR) / "scenes")) {
        if (file.path().extension() != ".yaml") continue;
        CAPTURE(file.path().filename());
        CHECK(bytes_of_file(file).starts_with("# yaml-language-server: $schema=schema.json\n"));
        for (const char* preset : {"", "draft", "preview", "final"})
            CHECK_NOTHROW(load_scene(file.path().string(), {preset, {}}));
        ++found;
    }
    CHECK(found >= 2);
}

TEST_CASE("Every scene for validation is valid, and scripts/validate runs it", "[scene]") {
    const fs::path root(FIRN_SOURCE_DIR);
    const std::string script = bytes_of_file(root / "scripts/validate");
    int found = 0;
    for (const auto& file : fs::directory_iterator(root / "scenes/validation")) {
        CAPTURE(file.path().filename());
        CHECK(bytes_of_file(file).starts_with("# yaml-language-server: $schema=../schema.json\n"));
        CHECK_NOTHROW(load_scene(file.path().string()));
        CHECK(script.find("simulate(\"" + file.path().stem().string() + "\"") != std::string::npos);
        ++found;
    }
    CHECK(found >= 7);
}

// The names of all keys that the schema knows, with the path to each.
static void collect(const nlohmann::ordered_json& schema, const std::string& path,
                    std::vector<std::string>& keys) {
    if (!schema.contains("properties")) return;
    for (const auto& [name, value] : schema["properties"].items()) {
        keys.push_back(path + name);
        collect(value, path + name + ".", keys);
    }
}

// The names of all keys that a resolved scene holds; the names of materials are the scene's own.
static void collect_written(const nlohmann::ordered_json& object, const std::string& path,
                            std::vector<std::string>& keys) {
    for (const auto& [name, value] : object.items()) {
        keys.push_back(path + name);
        if (value.is_object() && name != "materials") collect_written(value, path + name + ".", keys);
    }
}

TEST_CASE("The schema knows exactly the keys of a resolved scene", "[scene]") {
    const auto resolved =
        load_scene_text("grid_spacing: 0.1\nbodies: [{shape: {sphere: {radius: 1}}}]\n"
                        "picture: {slice: {point: [0, 0, 0]}}\n",
                        "s.yaml")
            .resolved;
    const auto schema = scene_schema();
    std::vector<std::string> known, written{"presets", "presets.draft", "presets.preview", "presets.final",
                                            "solver.flip_blend"};     // in place of flip_damping
    collect(schema, "", known);
    collect_written(resolved, "", written);
    std::sort(known.begin(), known.end());
    std::sort(written.begin(), written.end());
    CHECK(known == written);
    CHECK(schema["required"] == nlohmann::ordered_json{"grid_spacing", "bodies"});
    CHECK(schema["properties"]["solver"]["properties"]["beta"]["default"] == 0.6);
    CHECK(schema["properties"]["solver"]["properties"]["beta"]["exclusiveMinimum"] == 0);
}
