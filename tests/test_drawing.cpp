#include "app/chart.h"

#include <catch2/catch.hpp>

using namespace firn;
using Catch::Contains;

static int dark_pixels(const Image& image) {
    int count = 0;
    for (std::size_t i = 0; i < image.pixels.size(); i += 3) count += image.pixels[i] < 128;
    return count;
}

TEST_CASE("A drawing has the same marks as SVG and as a picture", "[drawing]") {
    Drawing d{60, 40, {}};
    const Drawing::Box box{10, 10, 20, 30, {200, 0, 0}};
    const Drawing::Line line{30, 5, 30, 35, 2, {0, 0, 0}};
    d.marks.emplace_back(box);
    d.marks.emplace_back(line);
    const Image image = to_image(d);
    REQUIRE(image.width == 60);
    const auto at = [&](int x, int y) { return image.pixels[3 * (std::size_t(y) * 60 + x) + 1]; };
    CHECK(at(15, 20) == 0);
    CHECK(at(5, 20) == 255);
    CHECK(at(30, 20) < 128);
    CHECK(at(40, 20) == 255);
    CHECK_THAT(to_svg(d), Contains("<rect x=\"10\" y=\"10\" width=\"10\" height=\"20\" fill=\"#c80000\"/>"));
    CHECK_THAT(to_svg(d), Contains("<line x1=\"30\" y1=\"5\" x2=\"30\" y2=\"35\""));
}

TEST_CASE("Text is drawn as wide as it says, and escaped in SVG", "[drawing]") {
    Drawing d{200, 40, {}};
    const Drawing::Text text{100, 30, "a<b & c", 1, 14, {}};
    d.marks.emplace_back(text);
    const Image image = to_image(d);
    CHECK(dark_pixels(image) > 20);
    const double width = text_width("a<b & c", 14);
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 200; ++x)
            if (x > 101 || x < 98 - width) REQUIRE(image.pixels[3 * (std::size_t(y) * 200 + x)] == 255);
    CHECK_THAT(to_svg(d), Contains(">a&lt;b &amp; c</text>") && Contains("text-anchor=\"end\""));
}

TEST_CASE("A chart puts larger values higher and farther right, and names every point", "[drawing]") {
    Chart chart{"title", "x", "y", {{"series", {{1, 1, "low"}, {10, 100, "high"}, {5, -1, "left out"}}, {200, 0, 0}}}, {}, {}};
    const std::string svg = to_svg(draw(chart));
    CHECK_THAT(svg, Contains(">low<") && Contains(">high<") && Contains(">title<") && Contains(">series<"));
    CHECK_THAT(svg, !Contains("left out") && !Contains("nan"));
    std::vector<Drawing::Box> dots;
    for (const auto& mark : draw(chart).marks)
        if (const auto* box = std::get_if<Drawing::Box>(&mark)) dots.push_back(*box);
    REQUIRE(dots.size() == 3);      // two points and the legend's
    CHECK(dots[1].x0 > dots[0].x0);
    CHECK(dots[1].y0 < dots[0].y0);
}
