#include "render/view.h"
#include "tests/small_pictures.h"

#include <algorithm>
#include <tuple>
#include <vector>

using namespace firn;

namespace {

/// A bed 0.1 m deep, its particles spread unevenly, about two to a cube of the spacing's edge; along its middle a drift
/// rises above it.
std::vector<float> bed(float drift = 0) {
    std::vector<float> x;
    for (int i = 0; i < 24'000; ++i)
        for (const auto& [number, extent, from] :
             {std::tuple(0.8191725, 1.2, -0.6), {0.6710436, 0.1, 0.0}, {0.5497005, 0.8, -0.4}})
            x.push_back(static_cast<float>(from + extent * std::fmod(i * number, 1.0)));
    for (std::size_t p = 0; p < x.size(); p += 3)
        x[p + 1] *= 1 + drift / 0.1f * std::exp(-40 * x[p + 2] * x[p + 2]);
    return x;
}

const Camera above{{0, 0.32, 1.1}, {0, 0.1, 0}, 30};

/// Brightness of what `above` sees of the bed.
double mean_of_bed(const Image& image) {
    double sum = 0;
    for (int y = 36; y < 52; ++y)
        for (int x = 40; x < 120; ++x) sum += brightness(image, x, y) / (16 * 80);
    return sum;
}

}  // namespace

TEST_CASE("snow is even to the eye that grazes it: particles do not show as beads", "[renderer]") {
    for (const Quality quality : {Quality::preview, Quality::final}) {
        const auto renderer = renderer_for(small_picture(quality));
        if (!renderer) return;
        const Image image = renderer->draw({bed(), {}, spacing}, ground, above, 0);
        double steps = 0;
        for (int y = 36; y < 52; ++y)
            for (int x = 40; x < 120; ++x)
                steps += std::abs(brightness(image, x, y) - brightness(image, x, y + 1)) / (16 * 80);
        CAPTURE(int(quality), mean_of_bed(image), steps);
        CHECK(steps / mean_of_bed(image) <
              (quality == Quality::final ? 0.008 : 0.014));  // twice as much with beads
        CHECK(steps / mean_of_bed(image) > 0.003);           // but there is grain
    }
}

TEST_CASE("a bed of snow is as bright as ground of snow in its place, whatever the sun's height",
          "[renderer]") {
    for (const double elevation : {15.0, 32.0, 60.0}) {
        Picture picture = small_picture(Quality::final);
        picture.sun_elevation = elevation;
        const auto renderer = renderer_for(picture);
        if (!renderer) return;
        const double particles = mean_of_bed(renderer->draw({bed(), {}, spacing}, ground, above, 0));
        const double plane =
            mean_of_bed(renderer->draw({{}, {}, spacing}, {{{Plane{{0, 0.1, 0}, {0, 1, 0}}}}}, above, 0));
        CAPTURE(elevation, particles, plane);
        CHECK(std::abs(particles - plane) < 5);
    }
}

TEST_CASE("powder before the sun shades a bed of snow as it shades a ground of snow, and throws light on",
          "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.sun_elevation = 25;
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    const std::vector<Solid> plane = {{{Plane{{0, 0.1, 0}, {0, 1, 0}}}}};
    const Vec3d middle = Vec3d(0, 0.1, 0) + 1.5 * sun_direction(picture).cast<double>();
    std::vector<float> none = bed(), cloud;
    for (int i = 0; i < 12'000; ++i)
        for (const auto& [number, extent, at] : {std::tuple(0.8191725, 1.8, middle.x()),
                                                 {0.6710436, 0.4, middle.y()},
                                                 {0.5497005, 1.4, middle.z()}})
            cloud.push_back(static_cast<float>(at + extent * (std::fmod(i * number, 1.0) - 0.5)));
    const auto moving = [](std::size_t still, std::size_t all) {
        std::vector<float> v(all, 0.0f);
        std::fill(v.begin() + static_cast<std::ptrdiff_t>(still), v.end(), 3.0f);
        return v;
    };
    std::vector<float> both = none;
    both.insert(both.end(), cloud.begin(), cloud.end());
    const double lit = mean_of_bed(renderer->draw({none, {}, spacing}, ground, above, 0));
    const double shaded =
        mean_of_bed(renderer->draw({both, moving(none.size(), both.size()), spacing}, ground, above, 0));
    const double plane_shaded =
        mean_of_bed(renderer->draw({cloud, moving(0, cloud.size()), spacing}, plane, above, 0));
    CAPTURE(lit, shaded, plane_shaded);
    CHECK(shaded < lit - 15);
    CHECK(std::abs(shaded - plane_shaded) < 20);  // 68 without what powder throws on
}

TEST_CASE("no grain is a dark speck on snow that is grazed behind a drift", "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.width = 320, picture.height = 180;
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    const Image image =
        renderer->draw({bed(0.04f), {}, spacing}, ground, {{0, 0.27, 1.6}, {0, 0.1, 0}, 24}, 0);
    int specks = 0;
    for (int y = 60; y < 110; ++y)
        for (int x = 80; x < 240; ++x) {
            std::vector<double> around;
            for (int i = -4; i <= 4; ++i) around.push_back(brightness(image, x + i, y));
            std::nth_element(around.begin(), around.begin() + 4, around.end());
            specks += brightness(image, x, y) < around[4] - 20;
        }
    CHECK(specks < 40);  // about a hundred if each grain is as sure of its face as any
}

TEST_CASE("a drift thins out over a ground of snow without a seam", "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.sun_azimuth = 250, picture.sun_elevation = 20;  // from behind: what faces the eye lies in shade
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    std::vector<float> wedge = bed();  // it ends at z = 0.2
    for (std::size_t p = 0; p < wedge.size(); p += 3)
        wedge[p + 1] *= std::clamp(0.5f - 2.5f * wedge[p + 2], 0.0f, 1.0f);
    std::vector<Solid> rising = ground;
    rising[0].velocity = {0, 0.5, 0};
    for (const double time : {0.0, 0.8}) {  // wherever the ground is
        const float rise = static_cast<float>(0.5 * time);
        std::vector<float> lifted = wedge;
        for (std::size_t p = 0; p < lifted.size(); p += 3) lifted[p + 1] += rise;
        const Image image =
            renderer->draw({lifted, {}, spacing}, rising, {{0, 0.32 + rise, 1.3}, {0, rise, 0.2}, 24}, time);
        const auto row = [&](int y) {
            double sum = 0;
            for (int x = 50; x < 110; ++x) sum += brightness(image, x, y) / 60;
            return sum;
        };
        double darkest = 255;
        for (int y = 25; y < 65; ++y) darkest = std::min(darkest, row(y));
        CAPTURE(time, darkest, row(20), row(70));
        CHECK(darkest > std::min(row(20), row(70)) - 35);  // 88 darker if each grain had a shaded side
    }
}

TEST_CASE("a steep foot keeps its shade over a ground of snow", "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.sun_azimuth = 250, picture.sun_elevation = 20;
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    std::vector<float> block = bed();  // its face stands at z = 0 and lies in shade
    for (std::size_t p = 0; p < block.size(); p += 3)
        block[p + 1] *= 2, block[p + 2] = block[p + 2] / 2 - 0.2f;
    const Camera camera{{0, 0.1, 1.2}, {0, 0.1, 0}, 24};
    const Image image = renderer->draw({block, {}, spacing}, ground, camera, 0);
    const auto at_height = [&](double height) {
        double sum = 0;
        for (int x = 50; x < 110; ++x)
            sum += brightness(image, x, static_cast<int>(pixel_of({0, height, 0}, camera, image)[1])) / 60;
        return sum;
    };
    CAPTURE(at_height(0.02), at_height(0.1));
    CHECK(at_height(0.02) < 0.78 * at_height(0.1));  // 0.85 if it were lit as the ground is
}

TEST_CASE("the lit foot of snow over a ground of snow has no dark specks between its grains", "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.width = 320, picture.height = 180;
    picture.sun_azimuth = 120, picture.sun_elevation = 30;  // from the eye's side
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    std::vector<float> block = bed();
    for (std::size_t p = 0; p < block.size(); p += 3)
        block[p + 1] = 0.6f * spacing + 2 * block[p + 1], block[p + 2] = block[p + 2] / 2 - 0.2f;
    const Camera camera{{0, 0.35, 1.2}, {0, 0.02, 0}, 14};
    const Image image = renderer->draw({block, {}, spacing}, ground, camera, 0);
    double darkest = 255, mean = 0;
    for (int y = 85; y < 115; ++y)  // the foot is in row 98
        for (int x = 0; x < 320; ++x) {
            darkest = std::min(darkest, brightness(image, x, y));
            mean += brightness(image, x, y) / (30 * 320);
        }
    CAPTURE(mean, darkest);
    CHECK(darkest > 0.75 * mean);  // 0.42 if the ground between the lowest grains lay in their shade
}

TEST_CASE("the level top of a bed is even as far as its far edge", "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.width = 320, picture.height = 180;
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    const Image image = renderer->draw({bed(), {}, spacing}, ground, {{0, 0.42, 1.7}, {0, 0.1, 0}, 24}, 0);
    const auto row = [&](int y) {
        double sum = 0;
        for (int x = 100; x < 220; ++x) sum += brightness(image, x, y) / 120;
        return sum;
    };
    double deepest = 0;
    for (int y = 76; y < 106; ++y) deepest = std::max(deepest, row(y - 4) - row(y));  // all of the top is there
    CAPTURE(deepest);
    CHECK(deepest < 3);  // 10 if hollows are measured along the ray: a step would run along the edge
}
