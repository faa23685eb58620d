#pragma once
#include <cstdint>

namespace firn {

/// 0 to 1, unrelated for neighbouring n: rounds of multiply and xor-shift.
inline float hash_of(std::uint32_t n) {
    n = (n ^ 61u ^ (n >> 16)) * 9u;
    n = (n ^ (n >> 4)) * 0x27d4eb2du;
    n = (n ^ (n >> 15)) * 0x85ebca6bu;
    return static_cast<float>((n ^ (n >> 13)) >> 8) / 16777216.0f;
}

}  // namespace firn
