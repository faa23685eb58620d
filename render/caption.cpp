#include "render/caption.h"

#include "render/text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace firn {

namespace {

using Rgb = std::array<std::uint8_t, 3>;
constexpr Rgb white{245, 246, 248}, dark{24, 28, 34};

int scale_of(const Image& image) { return std::max(1, std::min(image.height / 300, image.width / 400)); }

void fill(Image& image, int left, int top, int width, int height, const Rgb& colour) {
    for (int y = std::max(top, 0); y < std::min(top + height, image.height); ++y)
        for (int x = std::max(left, 0); x < std::min(left + width, image.width); ++x)
            std::copy(colour.begin(), colour.end(), &image.pixels[3 * (std::size_t(y) * image.width + x)]);
}

void write(Image& image, int left, int top, int scale, const std::string& text, const Rgb& colour) {
    for_each_box(text, [&](double x0, double y0, double x1, double y1) {
        fill(image, left + scale * int(x0), top + scale * int(y0), scale * int(x1 - x0), scale * int(y1 - y0), colour);
    });
}

/// White with a dark rim: legible on snow and on shade.
void write_rimmed(Image& image, int left, int top, int scale, const std::string& text) {
    for (const auto& [x, y] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}})
        write(image, left + scale * x, top + scale * y, scale, text, dark);
    write(image, left, top, scale, text, white);
}

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

}  // namespace

void draw_text(Image& image, const std::vector<std::string>& lines) {
    const int scale = scale_of(image);
    for (std::size_t i = 0; i < lines.size(); ++i)
        write_rimmed(image, 6 * scale, scale * (6 + int(i) * int(text_line)), scale, lines[i]);
}

void draw_legend(Image& image, Colour colour, const ColourRange& range) {
    const int scale = scale_of(image), width = 10 * scale, height = image.height / 2;
    const int left = image.width - width - 6 * scale, top = (image.height - height) / 2;
    fill(image, left - scale, top - scale, width + 2 * scale, height + 2 * scale, dark);
    for (int y = 0; y < height; ++y)
        fill(image, left, top + y, width, 1, mapped_colour(colour, 1 - (y + 0.5) / height));
    for (int step = 0; step <= 4; ++step) {
        const std::string text = number(range.low + 0.25 * step * (range.high - range.low));
        const int y = top + height - step * height / 4 - scale * int(text_height) / 2;
        write_rimmed(image, left - scale * (4 + int(text_width(text))), y, scale, text);
    }
    const std::string title = colour_title(colour);
    write_rimmed(image, image.width - scale * (6 + int(text_width(title))),
                 top - scale * int(text_height + 12), scale, title);
}

}  // namespace firn
