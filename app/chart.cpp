#include "app/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace firn {

static constexpr Color grey{200, 200, 200}, dark{60, 60, 60};

Color palette(std::size_t n) {
    static constexpr std::array<Color, 8> colors{{{31, 97, 161}, {201, 72, 30}, {44, 132, 60}, {128, 71, 152},
                                                  {176, 132, 16}, {20, 140, 150}, {190, 60, 120}, {90, 90, 90}}};
    return colors[n % colors.size()];
}

// One axis: decades, and where a value lies along it.
struct Scale {
    double low = 1e300, high = 0, from, to;     // values; pixels

    void include(double v) { if (v > 0 && std::isfinite(v)) low = std::min(low, v), high = std::max(high, v); }
    void settle(bool margin) {
        if (!(high > 0)) low = 0.1, high = 10;
        if (margin || low == high) low /= 1.4, high *= 1.4;
    }
    double at(double v) const { return from + (to - from) * std::log(v / low) / std::log(high / low); }
    std::vector<double> ticks() const {
        std::vector<double> all;
        const bool few = high / low < 150;
        for (double decade = std::pow(10, std::floor(std::log10(low))); decade <= high; decade *= 10)
            for (const double m : {1.0, 2.0, 5.0})
                if (const double v = m * decade; (m == 1 || few) && v >= low * 0.999 && v <= high * 1.001) all.push_back(v);
        return all;
    }
};

// Writes names beside their points where they cover no other name.
class Labels {
public:
    void place(Drawing& d, const Drawing::Text& text) {
        const double w = text_width(text.text, text.size), s = text.size;
        for (int ring = 0; ring < 12; ++ring)
            for (const double side : {0.0, 1.0}) {
                const double dy = (ring % 2 ? 1 : -1) * (ring + 1) / 2 * s;
                const double x = text.x + (side == 0 ? 6 : -6 - w), y = text.y + 4 + dy;
                if (!free(x, y - s, x + w, y) || x + w > d.width) continue;
                taken_.push_back({x, y - s, x + w, y, {}});
                if (ring > 1) d.marks.push_back(Drawing::Line{text.x, text.y, side == 0 ? x : x + w, y - 4, 0.5, grey});
                d.marks.push_back(Drawing::Text{x, y, text.text, 0, s, text.color});
                return;
            }
    }

private:
    bool free(double x0, double y0, double x1, double y1) const {
        return std::none_of(taken_.begin(), taken_.end(),
                            [&](const auto& b) { return x0 < b.x1 && x1 > b.x0 && y0 < b.y1 && y1 > b.y0; });
    }
    std::vector<Drawing::Box> taken_;
};

static void draw_axes(Drawing& d, const Scale& x, const Scale& y, const Chart& chart) {
    for (const double v : x.ticks()) {
        d.marks.push_back(Drawing::Line{x.at(v), y.from, x.at(v), y.to, 0.5, grey});
        d.marks.push_back(Drawing::Text{x.at(v), y.from + 15, fmt::format("{:g}", v), 0.5, 11, dark});
    }
    for (const double v : y.ticks()) {
        d.marks.push_back(Drawing::Line{x.from, y.at(v), x.to, y.at(v), 0.5, grey});
        d.marks.push_back(Drawing::Text{x.from - 5, y.at(v) + 4, fmt::format("{:g}", v), 1, 11, dark});
    }
    d.marks.push_back(Drawing::Line{x.from, y.from, x.to, y.from, 1, dark});
    d.marks.push_back(Drawing::Line{x.from, y.from, x.from, y.to, 1, dark});
    d.marks.push_back(Drawing::Text{(x.from + x.to) / 2, y.from + 32, chart.x_label, 0.5, 12, dark});
    d.marks.push_back(Drawing::Text{8, y.to - 10, chart.y_label, 0, 12, dark});
    d.marks.push_back(Drawing::Text{8, 18, chart.title, 0, 14, {}});
}

static void draw_series(Drawing& d, const Scale& x, const Scale& y, const Chart::Series& s, Labels& labels) {
    const Chart::Point* last = nullptr;
    for (const auto& p : s.points) {
        if (!(p.x > 0 && p.y > 0)) continue;
        if (s.line && last)
            d.marks.push_back(Drawing::Line{x.at(last->x), y.at(last->y), x.at(p.x), y.at(p.y), 1.5, s.color, s.dashed});
        last = &p;
    }
    for (const auto& p : s.points) {
        if (!s.dots || !(p.x > 0 && p.y > 0)) continue;
        d.marks.push_back(Drawing::Box{x.at(p.x) - 3, y.at(p.y) - 3, x.at(p.x) + 3, y.at(p.y) + 3, s.color});
        if (!p.name.empty()) labels.place(d, {x.at(p.x), y.at(p.y), p.name, 0, 10, s.color});
    }
}

static void draw_legend(Drawing& d, double x, double y, std::vector<Chart::Series> entries) {
    for (const auto& s : entries) {
        if (s.name.empty()) continue;
        if (s.line) d.marks.push_back(Drawing::Line{x, y, x + 22, y, 2, s.color, s.dashed});
        if (s.dots) d.marks.push_back(Drawing::Box{x + 7, y - 4, x + 15, y + 4, s.color});
        d.marks.push_back(Drawing::Text{x + 28, y + 4, s.name, 0, 11, dark});
        y += 16;
    }
}

Drawing draw(const Chart& chart) {
    Scale x, y;
    for (const auto& s : chart.series)
        for (const auto& p : s.points)
            if (p.x > 0 && p.y > 0) x.include(p.x), y.include(p.y);
    for (const auto& t : chart.tiles) x.include(t.x0), x.include(t.x1), y.include(t.y0), y.include(t.y1);
    x.settle(chart.tiles.empty()), y.settle(chart.tiles.empty());
    std::vector<Chart::Series> legend = chart.series;
    legend.insert(legend.end(), chart.legend.begin(), chart.legend.end());
    double beside = 0;
    for (const auto& s : legend) if (!s.name.empty()) beside = std::max(beside, 40 + text_width(s.name, 11));
    Drawing d{chart.width, chart.height, {}};
    x.from = 70, x.to = chart.width - 20 - beside, y.from = chart.height - 45, y.to = 60;
    for (const auto& t : chart.tiles)
        d.marks.push_back(Drawing::Box{x.at(t.x0), y.at(t.y0), x.at(t.x1), y.at(t.y1), t.color});
    draw_axes(d, x, y, chart);
    Labels labels;
    for (const auto& s : chart.series) draw_series(d, x, y, s, labels);
    draw_legend(d, x.to + 10, y.to + 6, legend);
    return d;
}

Drawing draw(const std::vector<Chart>& charts) {
    Drawing all;
    for (const auto& chart : charts) {
        all.add(draw(chart), all.width, 0);
        all.width += chart.width, all.height = std::max(all.height, chart.height);
    }
    return all;
}

}  // namespace firn
