#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace firn {

/// XXH3-128 of the pieces, one after the other, as 32 hexadecimal digits.
std::string hash_hex(const std::vector<std::string_view>& pieces);

}  // namespace firn
