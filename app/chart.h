#pragma once
#include "render/drawing.h"

namespace firn {

/// A chart with two logarithmic axes.
struct Chart {
    struct Point { double x, y; std::string name; };    ///< an empty name is not written.
    struct Series {
        std::string name;                               ///< in the legend; empty: not there.
        std::vector<Point> points;
        Color color;
        bool line = true, dots = true, dashed = false;
    };
    struct Tile { double x0, x1, y0, y1; Color color; };

    std::string title, x_label, y_label;
    std::vector<Series> series;     ///< points that are not above zero are left out.
    std::vector<Tile> tiles;        ///< below the series.
    std::vector<Series> legend;     ///< further entries.
    int width = 720, height = 480;  ///< [pixels]
};

Drawing draw(const Chart&);

/// Side by side.
Drawing draw(const std::vector<Chart>&);

/// The n-th of eight colours that can be told apart.
Color palette(std::size_t n);

}  // namespace firn
