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

TEST_CASE("a lens draws what is behind glass", "[renderer]") {
    for (const Quality quality : {Quality::draft, Quality::final}) {
        const auto renderer = renderer_for(small_picture(quality));
        if (!renderer) return;
        Solid pane{{Box{{0, 0.3, 0.6}, {1, 0.6, 0.01}}}};
        pane.look = Look::glass;
        Camera lens = front;
        lens.aperture = 0.05;
        const std::vector<float> particles = ball({0, 0.3, 0}, 0.2);
        const auto drawn = [&](const std::vector<float>& x) { return renderer->draw({x, {}, spacing}, {ground[0], pane}, lens, 0); };
        CHECK(difference_of(drawn(particles), drawn({})).pixels > 100);
    }
}

TEST_CASE("each look is drawn, and none like another", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    std::vector<std::vector<std::uint8_t>> pictures;
    for (const Look look : {Look::snow, Look::ice, Look::soil, Look::wood, Look::tiles, Look::concrete,
                            Look::metal, Look::glass}) {
        Solid plane{{Plane{}}}, box{{Box{{0, 0.3, 0}, {0.4, 0.6, 0.4}}}};
        plane.look = box.look = look;
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
