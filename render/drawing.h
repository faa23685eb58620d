#pragma once
#include "render/image.h"

#include <string>
#include <variant>

namespace firn {

struct Color { std::uint8_t r = 0, g = 0, b = 0; };

/// Lines, boxes and ASCII text on white, in pixels from the upper left corner, painted in their order.
struct Drawing {
    struct Line { double x0, y0, x1, y1, width; Color color; bool dashed = false; };
    struct Box { double x0, y0, x1, y1; Color color; };
    struct Text {
        double x, y;            ///< of the base line.
        std::string text;
        double anchor = 0;      ///< 0: begins at x, ½: centred there, 1: ends there.
        double size = 12;       ///< height of a line [pixels].
        Color color = {};
    };
    int width = 0, height = 0;
    std::vector<std::variant<Line, Box, Text>> marks;

    /// The other drawing at this place.
    void add(const Drawing&, double x, double y);
};

/// Width of the text in to_image [pixels].
double text_width(const std::string&, double size);

std::string to_svg(const Drawing&);
Image to_image(const Drawing&);

}  // namespace firn
