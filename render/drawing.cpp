#include "render/drawing.h"

#include "render/text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace firn {

namespace {

constexpr int fine = 3;                 // samples along each axis of a pixel
constexpr double dash = 5;              // [pixels]

/// A picture of `fine` times the size.
struct Canvas {
    int width, height;
    std::vector<Color> at;

    void fill(double x0, double y0, double x1, double y1, Color color) {
        const auto clip = [](double v, int most) { return static_cast<int>(std::clamp(std::round(v * fine), 0.0, double(most))); };
        for (int y = clip(std::min(y0, y1), height); y < clip(std::max(y0, y1), height); ++y)
            for (int x = clip(std::min(x0, x1), width); x < clip(std::max(x0, x1), width); ++x)
                at[static_cast<std::size_t>(y) * width + x] = color;
    }
    void paint(const Drawing::Box& b) { fill(b.x0, b.y0, b.x1, b.y1, b.color); }
    void paint(const Drawing::Line& l) {
        const double dx = l.x1 - l.x0, dy = l.y1 - l.y0, length = std::hypot(dx, dy);
        const int steps = std::max(1, static_cast<int>(length * fine * 1.5));
        for (int i = 0; i <= steps; ++i) {
            const double s = double(i) / steps;
            if (l.dashed && std::fmod(s * length, 2 * dash) > dash) continue;
            const double x = l.x0 + s * dx, y = l.y0 + s * dy, r = l.width / 2;
            fill(x - r, y - r, x + r, y + r, l.color);
        }
    }
    void paint(const Drawing::Text& t) {
        const double dot = t.size / text_line, x = t.x - t.anchor * text_width(t.text, t.size), y = t.y - text_height * dot;
        for_each_box(t.text, [&](double left, double top, double right, double bottom) {
            fill(x + dot * left, y + dot * top, x + dot * right, y + dot * bottom, t.color);
        });
    }
};

std::string hex(Color c) {
    char text[8];
    std::snprintf(text, sizeof text, "#%02x%02x%02x", c.r, c.g, c.b);
    return text;
}
std::string hundredths(double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", std::round(v * 100) / 100);
    return text;
}
std::string attribute(const char* name, double v) { return std::string(" ") + name + "=\"" + hundredths(v) + "\""; }

std::string svg(const Drawing::Line& l) {
    return "<line" + attribute("x1", l.x0) + attribute("y1", l.y0) + attribute("x2", l.x1) + attribute("y2", l.y1) +
           attribute("stroke-width", l.width) + " stroke=\"" + hex(l.color) + "\"" +
           (l.dashed ? " stroke-dasharray=\"5\"" : "") + "/>\n";
}
std::string svg(const Drawing::Box& b) {
    return "<rect" + attribute("x", std::min(b.x0, b.x1)) + attribute("y", std::min(b.y0, b.y1)) +
           attribute("width", std::abs(b.x1 - b.x0)) + attribute("height", std::abs(b.y1 - b.y0)) + " fill=\"" +
           hex(b.color) + "\"/>\n";
}
std::string svg(const Drawing::Text& t) {
    std::string escaped;
    for (const char c : printable(t.text)) escaped += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
    const char* const anchor = t.anchor < 0.25 ? "start" : t.anchor > 0.75 ? "end" : "middle";
    return "<text" + attribute("x", t.x) + attribute("y", t.y) + attribute("font-size", t.size) + " text-anchor=\"" +
           anchor + "\" fill=\"" + hex(t.color) + "\">" + escaped + "</text>\n";
}

}  // namespace

double text_width(const std::string& text, double size) {
    return text_width(text) * size / text_line;
}

void Drawing::add(const Drawing& other, double x, double y) {
    for (auto mark : other.marks) {
        if (auto* l = std::get_if<Line>(&mark)) l->x0 += x, l->x1 += x, l->y0 += y, l->y1 += y;
        if (auto* b = std::get_if<Box>(&mark)) b->x0 += x, b->x1 += x, b->y0 += y, b->y1 += y;
        if (auto* t = std::get_if<Text>(&mark)) t->x += x, t->y += y;
        marks.push_back(mark);
    }
}

std::string to_svg(const Drawing& drawing) {
    const std::string size = std::to_string(drawing.width) + "\" height=\"" + std::to_string(drawing.height);
    std::string text = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + size + "\" font-family=\"sans-serif\">\n" +
                       "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
    for (const auto& mark : drawing.marks) text += std::visit([](const auto& m) { return svg(m); }, mark);
    return text + "</svg>\n";
}

Image to_image(const Drawing& drawing) {
    Canvas canvas{drawing.width * fine, drawing.height * fine, {}};
    canvas.at.assign(static_cast<std::size_t>(canvas.width) * canvas.height, Color{255, 255, 255});
    for (const auto& mark : drawing.marks) std::visit([&](const auto& m) { canvas.paint(m); }, mark);
    Image image{drawing.width, drawing.height, {}};
    for (int y = 0; y < drawing.height; ++y)
        for (int x = 0; x < drawing.width; ++x) {
            int sum[3] = {0, 0, 0};
            for (int i = 0; i < fine * fine; ++i) {
                const Color c = canvas.at[static_cast<std::size_t>(y * fine + i / fine) * canvas.width + x * fine + i % fine];
                sum[0] += c.r, sum[1] += c.g, sum[2] += c.b;
            }
            for (const int s : sum) image.pixels.push_back(static_cast<std::uint8_t>(s / (fine * fine)));
        }
    return image;
}

}  // namespace firn
