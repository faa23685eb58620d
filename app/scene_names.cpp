#include "app/scene_names.h"

#include <algorithm>

namespace firn {

std::vector<std::string> shape_kinds(ShapeUse use) {
    Names visitor;
    describe_kinds(visitor, use);
    return visitor.names;
}

bool contains(const std::vector<std::string>& words, const std::string& word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

std::string home_of(const std::string& key) {
    if (contains(names_of<Scene>(), key) || key == "presets") return "at the top level";
    if (contains(names_of<Solver>(), key)) return "in solver";
    if (contains(names_of<SceneBody>(), key)) return "in an entry of bodies";
    if (contains(names_of<Solid>(), key)) return "in an entry of colliders";
    if (contains(names_of<Snow>(), key)) return "in a material";
    if (contains(names_of<Camera>(), key)) return "in camera";
    if (contains(names_of<Picture>(), key)) return "in picture";
    if (contains(names_of<CameraKey>(), key)) return "in an entry of camera.keyframes";
    return "";
}

}  // namespace firn
