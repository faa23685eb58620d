#include "app/hash.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <memory>

namespace firn {

std::string hash_hex(const std::vector<std::string_view>& pieces) {
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), XXH3_freeState);
    XXH3_128bits_reset(state.get());
    for (const auto piece : pieces) XXH3_128bits_update(state.get(), piece.data(), piece.size());
    const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace firn
