#pragma once
#include "app/scene.h"

#include <nlohmann/json.hpp>

namespace firn {

/// The scene with every key written out, in the order of the keys; reads back as the same scene.
nlohmann::ordered_json to_json(const Scene&);

/// The JSON Schema (draft 7) of scene files, for editors: what the reader accepts, presets included.
nlohmann::ordered_json scene_schema();

/// The dotted paths of the values that differ.
std::vector<std::string> differing_keys(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);

}  // namespace firn
