#include "render/latin1.h"

namespace firn {

std::optional<std::string> latin1_of(const std::string& utf8) {
    std::string result;
    for (std::size_t i = 0; i < utf8.size(); ++i) {
        const auto byte = static_cast<unsigned char>(utf8[i]);
        if (byte < 0x80) {
            result += utf8[i];
            continue;
        }
        // U+0080 to U+00FF are two bytes: 110000ab 10cdefgh.
        if ((byte != 0xC2 && byte != 0xC3) || i + 1 == utf8.size()) return std::nullopt;
        const auto next = static_cast<unsigned char>(utf8[++i]);
        if ((next & 0xC0) != 0x80) return std::nullopt;
        result += static_cast<char>(((byte & 3) << 6) | (next & 0x3F));
    }
    return result;
}

std::string utf8_of_latin1(const std::string& latin1) {
    std::string result;
    for (const char c : latin1) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x80) {
            result += c;
        } else {
            result += static_cast<char>(0xC0 | (byte >> 6));
            result += static_cast<char>(0x80 | (byte & 0x3F));
        }
    }
    return result;
}

}  // namespace firn
