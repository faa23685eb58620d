#include "tests/small_pictures.h"

#include <numeric>

using namespace firn;

namespace {

constexpr int width = 960, height = 540;  // as shipped scenes have it: more samples than the lens has taps

Picture wide_picture(Quality quality) {
    Picture picture = small_picture(quality);
    picture.width = width, picture.height = height;
    return picture;
}

constexpr double far_off = 6;  // [m]

/// Level: what is at `depth` is spread to `radius` [pixels], by thin lenses' A |d − f| / (2 d f) as a share of a pixel's
/// width at unit depth.
Camera camera_with(double radius, double depth, double focus) {
    Camera camera{{0, 1, far_off}, {0, 1, 0}, 40};
    const double pixel_tan = 2 * std::tan(20 * EIGEN_PI / 180) / height;
    camera.aperture = radius * pixel_tan * 2 * depth * focus / std::abs(depth - focus);
    camera.focus = focus;
    return camera;
}

/// A wall from there on to the right.
Solid wall(double left, double depth, Look look) {
    return {{Box{{left + 5, 1, far_off - depth - 0.5}, {10, 8, 1}}}, look};
}

/// A pixel's green as the film shows it, 0 to 1.
double on_film(const Image& image, int x, int y) {
    const double encoded = image.pixels[3 * (static_cast<std::size_t>(y) * image.width + x) + 1] / 255.0;
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// The light that made it so: 1 − exp(−1.55 x^1.45) turned round.
double light(const Image& image, int x, int y) {
    return std::pow(-std::log(1 - std::min(on_film(image, x, y), 0.999)) / 1.55, 1 / 1.45);
}

/// Of each column the mean light over the uppermost rows, above woods.
std::vector<double> columns_of(const Image& image) {
    std::vector<double> columns(image.width);
    for (int x = 0; x < image.width; ++x)
        for (int y = 0; y < height / 6; ++y) columns[x] += light(image, x, y) / (height / 6);
    return columns;
}

}  // namespace

TEST_CASE("an edge out of focus is spread as the lens's disc, and nothing of it stays sharp", "[renderer]") {
    struct Case {
        double depth, focus;  // of an edge before a wall that is as far, or before the sky [m]
    };
    for (const Quality quality : {Quality::preview, Quality::final}) {
        const auto renderer = renderer_for(wide_picture(quality));
        if (!renderer) return;
        for (const Case& c : {Case{far_off, 1}, Case{2, far_off}})
            for (const double radius : {0.0, 3.0, 9.0}) {
                const auto columns = [&](double left) {
                    std::vector<Solid> walls = {wall(left, c.depth, Look::soil)};
                    if (c.depth == far_off) walls.push_back(wall(-5, far_off + 0.001, Look::snow));
                    return columns_of(renderer->draw({}, walls, camera_with(radius, c.depth, c.focus), 0));
                };
                const auto none = columns(4), all = columns(-5), half = columns(0);
                const auto covered = [&](int x) { return (half[x] - none[x]) / (all[x] - none[x]); };
                const int reach = 16;
                double whole = 0, mean = 0, variance = 0, steepest = 0;
                for (int x = width / 2 - reach; x < width / 2 + reach; ++x) {
                    const double step = covered(x + 1) - covered(x);
                    whole += step, mean += step * x, variance += step * x * x;
                    steepest = std::max(steepest, step);
                }
                mean /= whole, variance = variance / whole - mean * mean;
                CAPTURE(int(quality), c.depth, radius, whole, mean, variance, steepest);
                REQUIRE(none[width / 2] - all[width / 2] > 0.2);
                CHECK(std::abs(whole - 1) < 0.02);
                CHECK(std::abs(mean - (width / 2 - 1)) < 0.2);
                // A straight edge before a disc: the slope is half an ellipse, of variance r²/4 and height 2/(π r).
                CHECK(std::abs(std::sqrt(variance) - radius / 2) < (radius > 0 ? 0.05 * radius : 0.6));
                if (radius > 0)  // with one sample for a pixel the disc's taps show a little
                    CHECK(steepest < (quality == Quality::final ? 1.4 : 2) * 2 / (EIGEN_PI * radius));
                else
                    CHECK(steepest > 0.7);
            }
    }
}

TEST_CASE(
    "powder out of focus hides as much, spread as the lens's disc, and stays sharp where it is in focus",
    "[renderer]") {
    const auto renderer = renderer_for(wide_picture(Quality::final));
    if (!renderer) return;
    const auto risen = [&](const ParticleView& powder, const Camera& camera) {
        const std::vector<Solid> dark = {wall(-5, far_off, Look::concrete)};
        const Image with = renderer->draw(powder, dark, camera, 0),
                    without = renderer->draw({}, dark, camera, 0);
        std::vector<double> light;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) light.push_back(on_film(with, x, y) - on_film(without, x, y));
        return light;
    };
    const auto sum = [](const std::vector<double>& light) {
        return std::accumulate(light.begin(), light.end(), 0.0);
    };
    const auto beside = [](const std::vector<double>& light, const std::vector<double>& other) {
        double all = 0;
        for (std::size_t i = 0; i < light.size(); ++i) all += other[i] < 0.005 ? light[i] : 0;
        return all;
    };
    const double depth = 2;
    std::vector<float> x, v;
    for (int j = -3; j <= 3; ++j)
        for (int i = -6; i <= 6; ++i) {
            for (const double at : {0.1 * i, 1 + 0.1 * j, far_off - depth})
                x.push_back(static_cast<float>(at));
            for (const double of : {1.0, 0.5, 0.2}) v.push_back(static_cast<float>(of));
        }
    for (const float speed : {1.0f, 30.0f}) {  // grains as points and as lines
        std::vector<float> fast = v;
        for (float& component : fast) component *= speed;
        const ParticleView powder{x, fast, spacing};
        const auto sharp = risen(powder, camera_with(0, far_off, 1));
        Camera camera = camera_with(6, far_off, 1);
        const auto blurred = risen(powder, camera);
        camera.focus = depth;
        const auto found = risen(powder, camera);
        CAPTURE(speed, sum(sharp), sum(blurred), beside(blurred, sharp), beside(found, sharp));
        REQUIRE(sum(sharp) > 5);
        CHECK(sum(blurred) / sum(sharp) == Approx(1).margin(0.15));
        CHECK(beside(blurred, sharp) > 0.4 * sum(sharp));
        CHECK(beside(found, sharp) < 0.1 * sum(sharp));
    }
}

TEST_CASE("powder behind a wall does not show, through a lens either", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::preview));
    if (!renderer) return;
    const std::vector<Solid> before = {wall(-5, far_off, Look::concrete)};
    for (const double radius : {0.0, 2.0}) {
        Camera camera = camera_with(1, far_off, 1);
        camera.aperture *= radius;
        const auto changed = [&](double z) {  // the wall's face is at 0
            std::vector<float> x, v;
            for (int i = -40; i <= 40; ++i)
                for (const double at : {0.02 * i, 1.0, z})
                    x.push_back(static_cast<float>(at)), v.push_back(3);
            return difference_of(renderer->draw({x, v, spacing}, before, camera, 0),
                                 renderer->draw({{}, {}, spacing}, before, camera, 0))
                .pixels;
        };
        CAPTURE(radius);
        CHECK(changed(-0.1) == 0);
        CHECK(changed(0.3) > 20);
    }
}
