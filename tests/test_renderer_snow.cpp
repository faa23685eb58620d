#include "tests/small_pictures.h"

using namespace firn;

namespace {

/// Pixels that are at least 20 steps brighter than all that lie two pixels off, as x and y by turns.
std::vector<int> sparks(const Image& image) {
    std::vector<int> found;
    for (int y = 2; y < image.height - 2; ++y)
        for (int x = 2; x < image.width - 2; ++x) {
            double brightest = 0;
            for (int k = -2; k <= 2; ++k)
                for (const auto& [i, j] :
                     {std::pair(k, -2), std::pair(k, 2), std::pair(-2, k), std::pair(2, k)})
                    brightest = std::max(brightest, brightness(image, x + i, y + j));
            if (brightness(image, x, y) > brightest + 20) found.push_back(x), found.push_back(y);
        }
    return found;
}

}  // namespace

TEST_CASE("snow is bright towards the sun, darker and bluer away from it, and never burnt", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::preview));
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0, 0}, 0.4);
    const Image image = renderer->draw({particles, {}, spacing}, {}, {{0, 0, 2}, {0, 0, 0}, 40}, 0);
    const double lit = brightness(image, 62, 35),
                 shaded = brightness(image, 98, 55);  // the sun is on the left
    CHECK(lit > 200);
    CHECK(lit < 252);
    CHECK(shaded < lit - 30);
    CHECK(shaded > 90);
    const std::size_t p = 3 * (55 * 160 + 98);
    CHECK(image.pixels[p + 2] > image.pixels[p] + 5);
}

TEST_CASE("what lies deep inside snow does not show, whatever its colour", "[renderer]") {
    for (const Quality quality : {Quality::draft, Quality::final}) {
        Picture picture = small_picture(quality);
        picture.colour = Colour::speed;
        const auto renderer = renderer_for(picture);
        if (!renderer) return;
        const std::vector<float> particles = ball({0, 0.4, 0}, 0.4);
        std::vector<float> plain(particles.size() / 3, 0.5f), core = plain;
        std::size_t changed = 0;
        for (std::size_t p = 0; p < core.size(); ++p) {
            const Vec3d from_center(particles[3 * p], particles[3 * p + 1] - 0.4f, particles[3 * p + 2]);
            if (from_center.norm() < 0.4 - 10 * spacing) core[p] = 1, ++changed;  // five cells deep
        }
        REQUIRE(changed > core.size() / 10);
        CHECK(renderer->draw({particles, {}, spacing, plain}, ground, front, 0).pixels ==
              renderer->draw({particles, {}, spacing, core}, ground, front, 0).pixels);
        plain.assign(plain.size(), 1.0f);
        CHECK(renderer->draw({particles, {}, spacing, plain}, ground, front, 0).pixels !=
              renderer->draw({particles, {}, spacing, core}, ground, front, 0).pixels);
    }
}

TEST_CASE("a slice cuts away what its normal points to, and shows the inside", "[renderer]") {
    Picture picture = small_picture();
    picture.colour = Colour::speed;
    const auto whole = renderer_for(picture);
    if (!whole) return;
    picture.slice = Plane{{0, 0, 0}, {0, 0, 1}};
    Renderer sliced(picture);
    const std::vector<float> particles = ball({0, 0.4, 0}, 0.4);
    std::vector<float> values(particles.size() / 3, 0.0f);
    for (std::size_t p = 0; p < values.size(); ++p)
        values[p] = Vec3d(particles[3 * p], particles[3 * p + 1] - 0.4f, particles[3 * p + 2]).norm() < 0.2;
    const Camera camera{{0, 0.4, 2.4}, {0, 0.4, 0}, 40};
    const ParticleView view{particles, {}, spacing, values};
    const auto yellow = [](const Image& image) {  // the upper end of viridis; its lower end is violet
        const std::size_t p = 3 * (45 * 160 + 80);
        return image.pixels[p] > 100 && image.pixels[p + 1] > 100 && image.pixels[p + 2] < 90;
    };
    CHECK_FALSE(yellow(whole->draw(view, {}, camera, 0)));
    CHECK(yellow(sliced.draw(view, {}, camera, 0)));
}

TEST_CASE("spray is drawn along its way while the shutter is open", "[renderer]") {
    Picture picture = small_picture(Quality::preview);
    picture.shutter = 0.05;
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    const std::vector<float> one = {0, 0.3f, 0}, fast = {8, 0, 0}, still = {0, 0, 0};
    const auto width = [&](const std::vector<float>& velocity) {
        const Image empty = renderer->draw({}, {}, front, 0);
        const Image image = renderer->draw({one, velocity, 0.1f}, {}, front, 0);
        int left = 160, right = 0;
        for (int y = 0; y < 90; ++y)
            for (int x = 0; x < 160; ++x)
                if (std::abs(brightness(image, x, y) - brightness(empty, x, y)) > 1)
                    left = std::min(left, x), right = std::max(right, x);
        return right - left;
    };
    CHECK(width(fast) > 1.5 * width(still));
    const double way = 8 * 0.05 * 45 / std::tan(20 * EIGEN_PI / 180) / 2.4;  // [pixels]
    CHECK(width(fast) <= width(still) + way);
}

TEST_CASE("a body's shade takes the sun from powder, too", "[renderer]") {
    std::vector<float> cloud, velocity;
    for (int k = -8; k <= 8; ++k)
        for (int j = -8; j <= 8; ++j)
            for (int i = -8; i <= 8; ++i)
                for (const double x : {0.05 * i, 0.3 + 0.05 * j, 0.05 * k}) {
                    cloud.push_back(static_cast<float>(x));
                    velocity.push_back(3);
                }
    const Solid screen{{Box{{-1.6, 1.3, 0}, {0.1, 3, 4}}}},  // the sun stands on the left
        dark{{Box{{0, 1, -2}, {9, 6, 1}}}, Look::soil};
    const auto renderer = renderer_for(small_picture(Quality::preview));
    if (!renderer) return;
    const auto warmth = [&](const std::vector<Solid>& bodies) {
        const Image image = renderer->draw({cloud, velocity, spacing}, bodies, front, 0);
        const std::size_t p = 3 * (45 * 160 + 80);
        return double(image.pixels[p]) / image.pixels[p + 2];
    };
    const double lit = warmth({dark}), shaded = warmth({dark, screen});
    CAPTURE(lit, shaded);
    CHECK(shaded < 0.8 * lit);
}

TEST_CASE("a particle eighteen pixels wide has grain finer than itself", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::final));
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0, 0}, 0.12);
    const Image image = renderer->draw({particles, {}, spacing}, {}, {{0, 0, 0.4}, {0, 0, 0}, 20}, 0);
    double sum = 0, bends = 0;
    for (int y = 20; y < 70; ++y)
        for (int x = 40; x < 120; ++x) {
            sum += brightness(image, x, y);
            bends += std::abs(brightness(image, x - 1, y) - 2 * brightness(image, x, y) +
                              brightness(image, x + 1, y));
        }
    CAPTURE(bends / sum);
    CHECK(bends / sum > 0.016);  // 0.010 where it is smooth
}

TEST_CASE("crystals in near snow glint, few of them, and stay when the camera moves", "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.exposure = 0.5;  // or sunlit snow would be as bright as they are
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.6, 0}, 0.5);
    const auto from = [&](double pixels, double distance) {
        const double pixel = 2 * distance * std::tan(6 * EIGEN_PI / 180) / picture.height;
        const Vec3d middle(-0.32, 0.92, 0.2 - pixels * pixel);  // on its face; the sun stands in −x
        return renderer->draw({particles, {}, spacing}, {},
                              Camera{middle + Vec3d(-distance, 0, 0), middle, 12}, 0);
    };
    constexpr int shift = 6;
    const std::vector<int> here = sparks(from(0, 1)), there = sparks(from(shift, 1)),
                           far = sparks(from(0, 12));
    const std::size_t pixels = std::size_t(picture.width) * picture.height, count = here.size() / 2;
    CAPTURE(count, there.size() / 2, far.size() / 2);
    CHECK(count > pixels / 2000);
    CHECK(count < pixels / 50);
    CHECK(far.size() < here.size() / 4);
    std::size_t stayed = 0, in_both = 0;
    for (std::size_t a = 0; a < here.size(); a += 2) {
        const int x = here[a] + shift;  // the camera looks along +x: its right is +z
        if (x > picture.width - 5) continue;
        ++in_both;
        bool found = false;
        for (std::size_t b = 0; b < there.size(); b += 2)
            found = found || std::max(std::abs(there[b] - x), std::abs(there[b + 1] - here[a + 1])) <= 1;
        stayed += found;
    }
    CAPTURE(stayed, in_both);
    CHECK(stayed > 0.7 * static_cast<double>(in_both));
}

TEST_CASE("crystals glint on a near ground of snow, on soil and tiles none do", "[renderer]") {
    Picture picture = small_picture(Quality::final);
    picture.exposure = 0.5;
    picture.sun_azimuth = 0, picture.sun_elevation = 38;  // where a mirror would show it
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    for (const Look look : {Look::snow, Look::soil, Look::tiles}) {
        std::vector<Solid> level = ground;
        level[0].look = look;
        const auto found =
            sparks(renderer->draw({{}, {}, spacing}, level, {{-0.5, 0.4, 0}, {0, 0, 0}, 24}, 0)).size() / 2;
        CAPTURE(static_cast<int>(look), found);
        CHECK((found > 5) == (look == Look::snow));
        if (look != Look::snow) continue;
        level[0].velocity = {0.3, 0, 0.1};  // it takes its grain and crystals along
        const Camera moved{{-0.2, 0.4, 0.1}, {0.3, 0, 0.1}, 24};
        const Image rested = renderer->draw({{}, {}, spacing}, level, {{-0.5, 0.4, 0}, {0, 0, 0}, 24}, 0);
        CHECK(difference_of(rested, renderer->draw({{}, {}, spacing}, level, moved, 1)).pixels < 20);
        CHECK(difference_of(rested, renderer->draw({{}, {}, spacing}, level, moved, 0)).pixels > 1000);
    }
}

TEST_CASE("against the sun snow shines at its edges, with the sun behind the eye it does not", "[renderer]") {
    const Camera camera{{0, 0.6, 0.8}, {0, 0.6, 0}, 24};
    for (const double azimuth : {90.0, 270.0}) {  // behind the eye, before it
        Picture picture = small_picture(Quality::preview);
        picture.sun_azimuth = azimuth, picture.sun_elevation = 15;
        const auto renderer = renderer_for(picture);
        if (!renderer) return;
        const Image image = renderer->draw({ball({0, 0.6, 0}, 0.1), {}, spacing}, {}, camera, 0);
        const auto upper_half = [&](double radius) {
            double sum = 0;
            for (double turn = EIGEN_PI / 6; turn < 5 * EIGEN_PI / 6; turn += EIGEN_PI / 90) {
                const auto [x, y] =
                    pixel_of({radius * std::cos(turn), 0.6 + radius * std::sin(turn), 0}, camera, image);
                sum += brightness(image, static_cast<int>(x), static_cast<int>(y)) / 60;
            }
            return sum;
        };
        const double edge = upper_half(0.095), middle = upper_half(0.04);
        CAPTURE(azimuth, edge, middle);
        if (azimuth < 180)
            CHECK(edge < middle);
        else
            CHECK(edge > 1.15 * middle);  // 0.97 of it without
    }
}
