#pragma once
#include <map>
#include <string>

namespace firn {

/// The files of shaders/ under their names, embedded by the build.
std::map<std::string, std::string> shader_sources();

}  // namespace firn
