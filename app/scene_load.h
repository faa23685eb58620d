#pragma once
#include "app/overrides.h"
#include "app/ply.h"
#include "app/scene_json.h"
#include "app/scene_read.h"

#include <map>
#include <string>
#include <vector>

namespace firn {

/// A scene that was found right, with every default filled in.
struct LoadedScene {
    std::string path;                       ///< as the user named its file.
    std::string name;                       ///< the file's name without extension.
    Scene scene;
    nlohmann::ordered_json resolved;        ///< `scene` as JSON; reads back as the same scene.
    std::string hash;  ///< of all that its frames depend on: resolved but for `frames`, and assets.
    std::map<std::size_t, PlyParticles>
        files;                              ///< what the bodies' particle files hold, by the body's index.
    ReadScene read;                         ///< where each key was written, for what is found wrong later.
};

/// Reads a scene and its assets. Throws SceneError with everything that is wrong.
LoadedScene load_scene(const std::string& path, const Overrides& = {});

/// The same for text; `path` is what errors call it and what asset paths are relative to.
LoadedScene load_scene_text(const std::string& text, const std::string& path, const Overrides& = {});

/// Reads a resolved scene, as run.json and checkpoints hold it, without its assets: for drawing, not for
/// running.
Scene read_resolved(const nlohmann::ordered_json& resolved, const std::string& path);

}  // namespace firn
