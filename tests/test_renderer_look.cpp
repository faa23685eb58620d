#include "render/compare.h"
#include "render/enlarged.h"
#include "tests/small_pictures.h"

using namespace firn;

TEST_CASE("a shadow falls away from the sun", "[renderer]") {
    const std::vector<float> particles = ball({0, 0.3, 0}, 0.3);
    for (const double azimuth : {0.0, 180.0}) {
        Picture picture = small_picture();
        picture.sun_azimuth = azimuth;
        const auto renderer = renderer_for(picture);
        if (!renderer) return;
        const Image image = renderer->draw({particles, {}, spacing}, ground, front, 0);
        // The shadow's middle is h/tan(32°) from the point under the ball's.
        const auto pixel = [&](double x) {
            return pixel_of({x, 0, 0}, Camera{{0, 0.6, 2.4}, {0, 0.6, 0}, 40}, image);
        };
        const double shift = pixel_of({0, 0.3, 0}, Camera{{0, 0.6, 2.4}, {0, 0.6, 0}, 40}, image)[1] - 45;
        const double side = azimuth == 0 ? -1 : 1;
        const auto shaded = pixel(side * 0.45), lit = pixel(-side * 0.45);
        CAPTURE(azimuth, shaded[0], lit[0], shaded[1] - shift);
        CHECK(brightness(image, int(shaded[0]), int(shaded[1] - shift)) + 25 <
              brightness(image, int(lit[0]), int(lit[1] - shift)));
    }
}

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

TEST_CASE("exposure goes from black to white", "[renderer]") {
    double before = -1;
    for (const double exposure : {0.0, 0.25, 1.0, 2.0, 1000.0}) {
        Picture picture = small_picture();
        picture.exposure = exposure;
        const auto renderer = renderer_for(picture);
        if (!renderer) return;
        const double now = brightness(renderer->draw({}, ground, front, 0), 80, 80);
        CAPTURE(exposure);
        CHECK(now > before);
        before = now;
        if (exposure == 0) CHECK(now <= 1);
    }
    CHECK(before == 255);
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

TEST_CASE("glass shows what is behind it, concrete does not", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.3, -1}, 0.2);
    Solid plate{{Box{{0, 0.5, 0}, {2, 2, 0.02}}}};
    const auto changed = [&](Look look) {
        plate.look = look;
        return difference_of(renderer->draw({particles, {}, spacing}, {plate}, front, 0),
                             renderer->draw({}, {plate}, front, 0))
            .pixels;
    };
    CHECK(changed(Look::concrete) == 0);
    CHECK(changed(Look::glass) > 100);
}

TEST_CASE("each look is drawn, and none like another", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    std::vector<std::vector<std::uint8_t>> pictures;
    for (const Look look : {Look::snow, Look::ice, Look::soil, Look::wood, Look::tiles, Look::concrete,
                            Look::metal, Look::glass}) {
        Solid plane{{Plane{}}}, box{{Box{{0, 0.3, 0}, {0.4, 0.6, 0.4}}}};
        plane.look = look == Look::glass ? Look::automatic : look, box.look = look;
        pictures.push_back(renderer->draw({}, {plane, box}, front, 0).pixels);
        for (std::size_t other = 0; other + 1 < pictures.size(); ++other)
            CHECK(pictures[other] != pictures.back());
    }
}

TEST_CASE("metal mirrors snow and bodies over it, right way down, and soil does not", "[renderer]") {
    Picture picture = small_picture(Quality::preview);
    picture.sun_azimuth = 90;  // from the side: shade falls past what is mirrored
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    const Camera level{{0, 0.5, 2.4}, {0, 0.5, 0}, 40};
    const Vec3d center(0, 0.25, 0);
    const std::vector<float> particles = ball(center, 0.12);
    const ParticleView none{{}, {}, spacing}, snow{particles, {}, spacing};
    for (const Look look : {Look::metal, Look::soil})
        for (const bool body : {false, true}) {
            std::vector<Solid> floor = ground;
            floor.front().look = look;
            const Image without = renderer->draw(none, floor, level, 0);
            if (body) floor.push_back({Sphere{center, 0.12}});
            const Image with = renderer->draw(body ? none : snow, floor, level, 0);
            const auto change_at = [&](double height) {
                const auto [x, y] = pixel_of({0, height, 0}, level, with);
                const std::size_t first = 3 * (std::size_t(y) * with.width + std::size_t(x));
                double sum = 0;
                for (std::size_t c = first; c < first + 3; ++c)
                    sum += std::abs(with.pixels[c] - without.pixels[c]) / 3.0;
                return sum;
            };
            CAPTURE(int(look), body, change_at(-0.25), change_at(-0.18), change_at(-0.08));
            const double least = 10;
            CHECK((change_at(-0.25) > least) == (look == Look::metal));
            CHECK((change_at(-0.18) > least) == (look == Look::metal));
            CHECK(change_at(-0.08) < least);  // between what is mirrored and its picture
        }
}

TEST_CASE("a pattern goes around what is round, as wide as on what is flat", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const Camera above{{0, 1, 0.01}, {0, 0, 0}, 16};
    const auto seen = [&](const Shape& shape, Look look) {
        Solid solid{{shape}};
        solid.look = look;
        return renderer->draw({}, {solid}, above, 0);
    };
    const Shape wide = Cylinder{{-3, -5, 0}, {3, -5, 0}, 5}, flat = Box{{0, -0.5, 0}, {6, 1, 3}};
    const double same = compare_images(seen(wide, Look::concrete), seen(flat, Look::concrete), 0).flip,
                 other = compare_images(seen(wide, Look::soil), seen(flat, Look::concrete), 0).flip;
    CAPTURE(same, other);
    CHECK(same < 0.1 * other);
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

TEST_CASE("a dark ground sends less light up, and of its own colour", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::preview));
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.6, 0}, 0.3);
    const auto below = [&](Look look) {  // mean colour under the ball
        Solid plane = ground[0];
        plane.look = look;
        const Image image =
            renderer->draw({particles, {}, spacing}, {plane}, Camera{{0, 0.02, 1}, {0, 0.6, 0}, 40}, 0);
        Vec3d sum = Vec3d::Zero();
        for (int y = 50; y < 65; ++y)
            for (int x = 75; x < 85; ++x)
                for (int c = 0; c < 3; ++c) sum[c] += image.pixels[3 * (160 * y + x) + c] / 150.0;
        return sum;
    };
    const Vec3d snow = below(Look::snow), soil = below(Look::soil), wood = below(Look::wood);
    CAPTURE(snow, soil, wood);
    CHECK(soil.y() < 0.93 * snow.y());
    CHECK(soil.y() < wood.y());
    CHECK(wood.x() / wood.z() > 1.03 * snow.x() / snow.z());
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
    Solid screen{{Box{{-1.6, 1.3, 0}, {0.1, 3, 4}}}};  // the sun stands on the left
    const auto renderer = renderer_for(small_picture(Quality::preview));
    if (!renderer) return;
    const auto warmth = [&](const std::vector<Solid>& bodies) {
        const Image image = renderer->draw({cloud, velocity, spacing}, bodies, front, 0);
        const std::size_t p = 3 * (45 * 160 + 80);
        return double(image.pixels[p]) / image.pixels[p + 2];
    };
    const double lit = warmth({}), shaded = warmth({screen});
    CAPTURE(lit, shaded);
    CHECK(shaded < 0.8 * lit);
}

TEST_CASE("an outline in final fades over two pixels, as a tent of that width has it", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::final));
    if (!renderer) return;
    const Solid wall{{Box{{-5, 0, -5}, {10, 30, 10}}}};  // its right edge leans in perspective
    const Image image = renderer->draw({}, {wall}, Camera{{0.3, 8, 2}, {0, 0, 0}, 40}, 0);
    constexpr int rows = 70;
    int between = 0;  // pixels that neither neighbour is like
    for (int y = 10; y < 10 + rows; ++y)
        for (int x = 1; x < 159; ++x) {
            const double here = brightness(image, x, y);
            between += std::abs(here - brightness(image, x - 1, y)) > 4 &&
                       std::abs(here - brightness(image, x + 1, y)) > 4;
        }
    CHECK(between > 1.5 * rows);
}

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
    picture.exposure = 0.5, picture.sun_azimuth = 0, picture.sun_elevation = 38;  // where a mirror would show it
    const auto renderer = renderer_for(picture);
    if (!renderer) return;
    for (const Look look : {Look::snow, Look::soil, Look::tiles}) {
        std::vector<Solid> level = ground;
        level[0].look = look;
        const auto found =
            sparks(renderer->draw({{}, {}, spacing}, level, {{-0.5, 0.4, 0}, {0, 0, 0}, 24}, 0)).size() / 2;
        CAPTURE(static_cast<int>(look), found);
        CHECK((found > 5) == (look == Look::snow));
    }
}

TEST_CASE("a ramp that is enlarged is the same ramp, level where the samples end", "[renderer]") {
    constexpr int width = 41, height = 25;
    for (const double edge : {0.5, 0.4}) {
        Image samples{int(std::ceil(edge * width)), int(std::ceil(edge * height)), {}};
        const auto ramp = [&](double x, double y) {  // about the middle [pixels]
            return std::array{128 + 4 * x, 128 - 7 * y, 128 + 2 * x + 3 * y};
        };
        for (int j = 0; j < samples.height; ++j)
            for (int i = 0; i < samples.width; ++i)
                for (const double v :
                     ramp((i + 0.5 - 0.5 * samples.width) / edge, (j + 0.5 - 0.5 * samples.height) / edge))
                    samples.pixels.push_back(static_cast<std::uint8_t>(std::lround(v)));
        const Image picture = enlarged(samples, width, height, edge);
        const double right = (0.5 * samples.width - 0.5) / edge, low = (0.5 * samples.height - 0.5) / edge;
        REQUIRE(picture.pixels.size() == 3 * width * height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const auto expected = ramp(std::clamp(x + 0.5 - 0.5 * width, -right, right),
                                           std::clamp(y + 0.5 - 0.5 * height, -low, low));
                // To a half for the samples, another for the picture, and 1/32 of a step between samples along each axis.
                for (int c = 0; c < 3; ++c)
                    REQUIRE(std::abs(picture.pixels[3 * (y * width + x) + c] - expected[c]) <
                            1 + 11 / edge / 32);
            }
    }
}

TEST_CASE("preview is final with less care", "[renderer]") {
    const auto preview = renderer_for(small_picture(Quality::preview));
    if (!preview) return;
    const std::vector<float> particles = ball({0, 0.3, 0}, 0.3);
    const ParticleView view{particles, {}, spacing};
    const Image quick = preview->draw(view, ground, front, 0);
    const Image careful = Renderer(small_picture(Quality::final)).draw(view, ground, front, 0);
    const ImageDifference difference = compare_images(quick, careful, 0.1);
    CAPTURE(difference.psnr, difference.share_above);
    CHECK(difference.psnr > 25);
    CHECK(difference.share_above < 0.05);
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
