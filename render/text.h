#pragma once
#include <functional>
#include <string>

namespace firn {

constexpr double text_height = 8;   ///< from the top of a capital to its base line, and one dot below [dots of the font].
constexpr double text_line = 11;    ///< from line to line [dots].

/// Calls box(left, top, right, bottom) for the boxes that make up a line of text, in dots to the right of its
/// beginning and below its top. ASCII: the font (stb_easy_font) has nothing else, and shows ? instead.
void for_each_box(const std::string& text, const std::function<void(double, double, double, double)>& box);

/// [dots]
double text_width(const std::string&);

/// With ? for what the font does not have.
std::string printable(std::string text);

}  // namespace firn
