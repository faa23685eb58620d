#pragma once
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <map>

// A few hundred particles that fall onto the ground, and pictures of a few hundred pixels.
inline const std::string small_scene = R"(title: Wurf — test
grid_spacing: 0.08
frames: 6
fps: 24
solver: {integrator: explicit, weights: quadratic}
bodies: [{shape: {sphere: {center: [0, 0.22, 0], radius: 0.2}}, velocity: [1, -3, 0]}]
colliders: [{shape: {plane: {}}}]
picture: {width: 64, height: 36, quality: draft}
)";

// Every file of an output folder with its bytes; of run.json only what must not depend on the machine's
// speed.
inline std::map<std::string, std::string> files_of(const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& file : std::filesystem::recursive_directory_iterator(folder)) {
        const std::string name = std::filesystem::relative(file.path(), folder).string();
        if (file.is_directory() || name == "checkpoint.firn") continue;
        files[name] = bytes_of_file(file.path());
        if (name != "run.json") continue;
        auto json = nlohmann::ordered_json::parse(files[name]);
        json.erase("threads");
        for (auto& frame : json["frames"])
            for (const char* key : {"simulate_seconds", "render_seconds", "encode_seconds"}) frame.erase(key);
        files[name] = json.dump();
    }
    return files;
}

inline bool same_files(const std::filesystem::path& a, const std::filesystem::path& b) {
    const auto in_a = files_of(a), in_b = files_of(b);
    for (const auto& [name, bytes] : in_a)
        if (!in_b.contains(name) || in_b.at(name) != bytes) UNSCOPED_INFO("differs: " << name);
    for (const auto& [name, bytes] : in_b)
        if (!in_a.contains(name)) UNSCOPED_INFO("missing: " << name);
    return in_a == in_b;
}
