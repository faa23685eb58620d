#include "app/utf8.h"

#include <fmt/format.h>

namespace firn {

// Length of the UTF-8 sequence at `i`, or 0 if there is none: overlong forms, surrogates and what lies beyond
// U+10FFFF are none (Unicode standard, table 3-7).
static std::size_t sequence_length(const std::string& s, std::size_t i) {
    const auto byte = [&](std::size_t k) -> unsigned {
        return k < s.size() ? static_cast<unsigned char>(s[k]) : 0;
    };
    const auto tail = [&](std::size_t k) { return byte(k) >= 0x80 && byte(k) <= 0xBF; };
    const unsigned a = byte(i), b = byte(i + 1);
    if (a < 0x80) return 1;
    if (a >= 0xC2 && a <= 0xDF) return tail(i + 1) ? 2 : 0;
    if (a >= 0xE0 && a <= 0xEF) {
        const bool good = b >= (a == 0xE0 ? 0xA0u : 0x80u) && b <= (a == 0xED ? 0x9Fu : 0xBFu);
        return good && tail(i + 2) ? 3 : 0;
    }
    if (a >= 0xF0 && a <= 0xF4) {
        const bool good = b >= (a == 0xF0 ? 0x90u : 0x80u) && b <= (a == 0xF4 ? 0x8Fu : 0xBFu);
        return good && tail(i + 2) && tail(i + 3) ? 4 : 0;
    }
    return 0;
}

static bool is_control(const std::string& s, std::size_t i, std::size_t length) {
    const auto a = static_cast<unsigned char>(s[i]);
    if (length == 1) return (a < 0x20 && a != '\t' && a != '\n') || a == 0x7F;
    return length == 2 && a == 0xC2 && static_cast<unsigned char>(s[i + 1]) < 0xA0 && s[i + 1] != '\x85';
}

std::optional<TextFault> find_text_fault(const std::string& s) {
    if (s.starts_with("\xFF\xFE") || s.starts_with("\xFE\xFF") || (s.size() > 1 && (!s[0] || !s[1])))
        return TextFault{1, 1, "this is UTF-16 or UTF-32; save the scene as UTF-8"};
    TextFault at;
    bool indenting = true;
    for (std::size_t i = 0; i < s.size();) {
        const std::size_t length = sequence_length(s, i);
        if (length == 0) {
            at.message = fmt::format("byte 0x{:02x} is not UTF-8 text", static_cast<unsigned char>(s[i]));
            return at;
        }
        const bool line_end = s[i] == '\r' && i + 1 < s.size() && s[i + 1] == '\n';
        if (is_control(s, i, length) && !line_end) {
            at.message =
                fmt::format("control character 0x{:02x}", static_cast<unsigned char>(s[i + length - 1]));
            return at;
        }
        if (s[i] == '\t' && indenting) {
            const std::size_t next = s.find_first_not_of(" \t\r", i);
            if (next != std::string::npos && s[next] != '\n' && s[next] != '#') {
                at.message = "a tab indents this line; YAML wants spaces";
                return at;
            }
            indenting = false;  // an empty line or a comment, whose other tabs need no search
        }
        indenting = s[i] == '\n' || (indenting && (s[i] == ' ' || s[i] == '\t'));
        if (s[i] == '\n') ++at.line, at.column = 1;
        else ++at.column;
        i += length;
    }
    return {};
}

bool is_printable(const std::string& s) {
    for (std::size_t i = 0; i < s.size();) {
        const std::size_t length = sequence_length(s, i);
        if (length == 0 || is_control(s, i, length)) return false;
        i += length;
    }
    return true;
}

}  // namespace firn
