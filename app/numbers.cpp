#include "app/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace firn {

bool Range::holds(double value) const {
    return (above_lower ? value > lower : value >= lower) && (below_upper ? value < upper : value <= upper);
}

std::string Range::text() const {
    std::string words;
    if (std::isfinite(lower)) words = fmt::format("{} {}", above_lower ? "above" : "at least", lower);
    if (std::isfinite(upper))
        words += fmt::format("{}{} {}", words.empty() ? "" : ", ", below_upper ? "below" : "at most", upper);
    return words.empty() ? "any finite number" : words;
}

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

// Where a decimal number ends that begins at the text's start: [+-] digits [. digits] [e [+-] digits].
struct Extent { std::size_t end = 0; bool whole = true; };
static Extent number_extent(const std::string& s) {
    std::size_t i = !s.empty() && (s[0] == '-' || s[0] == '+');
    const auto digits = [&] {
        const auto from = i;
        while (i < s.size() && is_digit(s[i])) ++i;
        return i - from;
    };
    std::size_t mantissa = digits();
    bool whole = true;
    if (i < s.size() && s[i] == '.') ++i, mantissa += digits(), whole = false;
    if (mantissa == 0) return {0, false};
    const std::size_t before_exponent = i;
    if (i < s.size() && (s[i] == 'e' || s[i] == 'E')) {
        ++i;
        if (i < s.size() && (s[i] == '-' || s[i] == '+')) ++i;
        if (digits() > 0) return {i, false};
    }
    return {before_exponent, whole};
}

static std::string no_number(const std::string& s, std::size_t end) {
    std::string word = s;
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    const std::string bare = word.substr(std::min(word.find_first_not_of("+-."), word.size()));
    if (bare == "inf" || bare == "nan" || bare == "infinity") return "must be finite";
    if (word.starts_with("0x") || word.starts_with("0o") || word.starts_with("0b"))
        return "is not decimal; write the number in decimal";
    if (end > 0 && end < s.size()) {
        if (s[end] == ',') return "holds a comma; write a decimal point";
        if (s[end] == '_') return "holds an underscore; write the digits alone";
        return fmt::format("has something behind the number; write {} alone, units are fixed",
                           s.substr(0, end));
    }
    return "is not a number";
}

ParsedNumber parse_number(const std::string& s) {
    ParsedNumber number;
    const Extent extent = number_extent(s);
    number.whole = extent.whole;
    const std::string shown = s.size() > 40 ? s.substr(0, 40) + "..." : s;
    if (extent.end != s.size() || s.empty()) {
        number.fault = fmt::format("{} {}", shown, no_number(s, extent.end));
        return number;
    }
    const std::size_t first = s[0] == '-' || s[0] == '+';
    if (first + 1 < s.size() && s[first] == '0' && is_digit(s[first + 1])) {
        number.fault = fmt::format("{} begins with 0, which some read as octal; leave the 0 out", shown);
        return number;
    }
    const auto result = std::from_chars(s.data() + (s[0] == '+'), s.data() + s.size(), number.value);
    if (result.ec != std::errc())
        number.fault = fmt::format("{} is too large or too near to 0 for a number; it must be finite", shown);
    return number;
}

std::optional<std::int64_t> parse_whole(const std::string& s) {
    std::int64_t value = 0;
    const auto result = std::from_chars(s.data() + s.starts_with('+'), s.data() + s.size(), value);
    if (result.ec != std::errc() || result.ptr != s.data() + s.size()) return {};
    return value;
}

}  // namespace firn
