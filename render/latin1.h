#pragma once
#include <optional>
#include <string>

namespace firn {

/// UTF-8 as Latin-1, where every character has a place in it.
std::optional<std::string> latin1_of(const std::string& utf8);

std::string utf8_of_latin1(const std::string& latin1);

}  // namespace firn
