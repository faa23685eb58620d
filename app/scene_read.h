#pragma once
#include "app/scene.h"
#include "app/yaml.h"

#include <map>
#include <string>

namespace firn {

/// A scene as it was written, and where.
struct ReadScene {
    Scene scene;
    std::map<std::string, Place> places;  ///< of every value that was given, by its key path.

    bool given(const std::string& path) const { return places.contains(path); }
    Place place(std::string path) const;  ///< of the value, or of the nearest one around it that was given.
};

/// Reads a scene without its presets. What is wrong goes to the problems; such keys keep their defaults.
ReadScene read_scene(const Yaml& root, Problems&);

/// `parent.name`, or `name` at the top.
std::string child_path(const std::string& parent, const std::string& name);

/// Tells of every key of the mapping that is given again.
void check_duplicates(const Yaml& mapping, const std::string& path, Problems&);

}  // namespace firn
