#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace firn {

/// What a number may be. A bound is written as `above(0).up_to(1)`: 0 < value ≤ 1.
struct Range {
    double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
    bool above_lower = false, below_upper = false;  ///< the bound itself is not allowed.

    constexpr Range up_to(double bound) const { return {lower, bound, above_lower, false}; }
    constexpr Range below(double bound) const { return {lower, bound, above_lower, true}; }
    bool holds(double value) const;     ///< false for NaN.
    std::string text() const;           ///< "above 0, at most 1"
};

constexpr Range above(double bound) { return {bound, std::numeric_limits<double>::infinity(), true, false}; }
constexpr Range at_least(double bound) {
    return {bound, std::numeric_limits<double>::infinity(), false, false};
}
constexpr Range within(double bound) { return {-bound, bound, false, false}; }  ///< −bound ≤ value ≤ bound.

/// A number as written in a scene: decimal, with point and exponent. `fault` is empty where it is one.
struct ParsedNumber {
    double value = 0;
    bool whole = false;     ///< written without point and exponent.
    std::string fault;      ///< what is wrong, and how to write it.
};
ParsedNumber parse_number(const std::string& text);

/// A whole number to its last digit, or none if it is none or has more than 63 bits.
std::optional<std::int64_t> parse_whole(const std::string& text);

}  // namespace firn
