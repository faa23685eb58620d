#pragma once
#include "app/yaml.h"

#include <string>
#include <vector>

namespace firn {

/// What the command line changes in a scene.
struct Overrides {
    std::string preset;                 ///< of the scene's `presets`; empty: none.
    std::vector<std::string> settings;  ///< KEY=VALUE, applied in order after the preset.
};

/// Puts `over` on top of `base`: mappings key by key, everything else replaced. A list's entries can be named
/// by their index ({0: {...}}), a key can be a dotted path (bodies.0.sampling), and a shape of another kind
/// replaces the shape.
void override_with(Yaml& base, const Yaml& over, const std::string& path, Problems&);

/// The scene's presets, taken out of the tree; their values know that they came from there.
std::vector<Yaml::Entry> take_presets(Yaml& root, Problems&);

/// Applies one KEY=VALUE. Throws SceneError, or adds to the problems, with `--set` as the file.
void apply_setting(Yaml& root, const std::string& setting, Problems&);

}  // namespace firn
