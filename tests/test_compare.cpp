#include "render/compare.h"
#include "render/flip.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

using namespace firn;

namespace {

Image image_of(int width, int height, const std::function<int(int, int, int)>& value) {
    Image image{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                image.pixels.push_back(static_cast<std::uint8_t>(value(x, y, c) % 256));
    return image;
}

const Image ramp = image_of(32, 24, [](int x, int y, int c) { return x * 7 + y * 5 + c * 40; });
const Image noisy = image_of(
    32, 24, [](int x, int y, int c) { return x * 7 + y * 5 + c * 40 + (x * 31 + y * 17 + c * 11) % 23; });
const Image other = image_of(32, 24, [](int x, int y, int c) { return x * x + 3 * y * y + x * y * (c + 1); });

Image flat(int width, int height, int value) {
    return image_of(width, height, [=](int, int, int) { return value; });
}

}  // namespace

TEST_CASE("a picture does not differ from itself", "[compare]") {
    const ImageDifference d = compare_images(ramp, ramp, 0);
    CHECK(d.mean_error == 0);
    CHECK(d.max_error == 0);
    CHECK(std::isinf(d.psnr));
    CHECK(d.ssim == Approx(1).epsilon(1e-12));
    CHECK(d.share_above == 0);
}

// Reference values from the authors' own program (flip-evaluator 1.x, LDR), which calculates in float.
TEST_CASE("FLIP agrees with its authors' program", "[compare]") {
    const auto mixed = [](int step, int shift) {
        return image_of(48, 40, [=](int x, int y, int c) {
            return (x + shift) * 7 + y * 13 + c * step + (x * y) % 17 * 5;
        });
    };
    CHECK(flip(mixed(31, 0), mixed(37, 1)) == Approx(0.37092099).margin(2e-4));
    const auto with_disc = [](int value) {
        return image_of(48, 40, [=](int x, int y, int c) {
            const bool inside = (x - 20) * (x - 20) + (y - 20) * (y - 20) <= 36;
            return c == 0 ? x * 5 : c == 1 ? y * 6 : inside ? value : 128;
        });
    };
    const Image plain = with_disc(128), disc = with_disc(180);
    CHECK(flip(plain, disc) == Approx(0.04193177).margin(2e-4));
    const std::vector<float> map = flip_map(plain, disc);
    CHECK(*std::max_element(map.begin(), map.end()) == Approx(0.44075549).margin(2e-3));
    CHECK(flip(flat(48, 40, 0), flat(48, 40, 255)) == Approx(0.96740073).margin(2e-4));
    CHECK(flip(disc, disc) == 0);
}

TEST_CASE("black and white differ by everything", "[compare]") {
    const ImageDifference d = compare_images(flat(20, 15, 0), flat(20, 15, 255), 0.5);
    CHECK(d.mean_error == 1);
    CHECK(d.max_error == 1);
    CHECK(d.psnr == Approx(0).margin(1e-12));
    CHECK(d.ssim == Approx(1e-4 / 1.0001));  // C₁/(1 + C₁): no structure in either
    CHECK(d.share_above == 1);
}

// Reference values from scikit-image 0.26 and numpy; SSIM on luma with a Gaussian window, σ = 1.5.
TEST_CASE("differences agree with another implementation", "[compare]") {
    const ImageDifference near_by = compare_images(ramp, noisy, 0.05);
    CHECK(near_by.mean_error == Approx(0.0818627451).epsilon(1e-9));
    CHECK(near_by.max_error == Approx(0.9960784314).epsilon(1e-9));
    CHECK(near_by.psnr == Approx(13.8267703208).epsilon(1e-9));
    CHECK(near_by.ssim == Approx(0.5267817751).epsilon(1e-8));
    CHECK(near_by.share_above == Approx(0.9205729167).epsilon(1e-9));
    const ImageDifference far_off = compare_images(ramp, other, 0.05);
    CHECK(far_off.psnr == Approx(7.8805455560).epsilon(1e-9));
    CHECK(far_off.ssim == Approx(0.0326758191).epsilon(1e-7));
    CHECK(far_off.share_above == Approx(0.9947916667).epsilon(1e-9));
}

TEST_CASE("one pixel of a hundred is one percent", "[compare]") {
    Image changed = flat(10, 10, 100);
    changed.pixels[3 * 42 + 1] = 110;
    const ImageDifference d = compare_images(flat(10, 10, 100), changed, 9.5 / 255);
    CHECK(d.share_above == Approx(0.01));
    CHECK(d.max_error == Approx(10.0 / 255));
    CHECK(d.mean_error == Approx(10.0 / 255 / 300));
    CHECK(compare_images(flat(10, 10, 100), changed, 10.0 / 255).share_above == 0);
}

TEST_CASE("pictures smaller than the window of SSIM can be compared", "[compare]") {
    for (const auto& [width, height] : {std::pair(1, 1), {1, 20}, {20, 1}, {5, 3}}) {
        CAPTURE(width, height);
        CHECK(compare_images(flat(width, height, 9), flat(width, height, 9), 0).ssim == Approx(1));
        const double ssim = compare_images(flat(width, height, 0), flat(width, height, 255), 0).ssim;
        CHECK(ssim == Approx(1e-4 / 1.0001));
    }
}

TEST_CASE("pictures of different sizes cannot be compared", "[compare]") {
    CHECK_THROWS_AS(compare_images(flat(4, 3, 0), flat(3, 4, 0), 0), std::invalid_argument);
    CHECK_THROWS_AS(heat_map(flat(4, 3, 0), flat(4, 4, 0), 1), std::invalid_argument);
}

TEST_CASE("a heat map gets brighter all the way from black to white", "[compare]") {
    double before = -1;
    for (int difference = 0; difference <= 100; ++difference) {
        CAPTURE(difference);
        const Image map = heat_map(flat(1, 1, 50), flat(1, 1, 50 + difference), 100 / 255.0);
        const double luma = 0.2126 * map.pixels[0] + 0.7152 * map.pixels[1] + 0.0722 * map.pixels[2];
        CHECK(luma > before);
        before = luma;
    }
    CHECK(heat_map(ramp, ramp, 1).pixels == flat(32, 24, 0).pixels);
    CHECK(heat_map(flat(2, 2, 0), flat(2, 2, 255), 0.5).pixels == flat(2, 2, 255).pixels);
}
