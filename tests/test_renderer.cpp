#include "render/compare.h"
#include "render/renderer.h"

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>

using namespace firn;

namespace {

constexpr float spacing = 0.02f;

Picture small_picture(Quality quality = Quality::draft) {
    Picture picture;
    picture.width = 160, picture.height = 90, picture.quality = quality;
    return picture;
}

/// None where this machine has no OpenGL, with a warning that says so.
std::unique_ptr<Renderer> renderer_for(const Picture& picture) {
    try {
        return std::make_unique<Renderer>(picture);
    } catch (const GLError& error) {
        WARN("skipped, as there is no OpenGL here: " << error.what());
        return nullptr;
    }
}

/// A ball of particles on a lattice.
std::vector<float> ball(const Vec3d& center, double radius) {
    std::vector<float> x;
    const int n = static_cast<int>(radius / spacing);
    for (int k = -n; k <= n; ++k)
        for (int j = -n; j <= n; ++j)
            for (int i = -n; i <= n; ++i) {
                const Vec3d p = Vec3d(i, j, k) * spacing;
                if (p.norm() > radius) continue;
                for (int a = 0; a < 3; ++a) x.push_back(static_cast<float>(center[a] + p[a]));
            }
    return x;
}

const std::vector<Solid> ground = {{{Plane{}}}};
const Camera front{{0, 0.6, 2.4}, {0, 0.3, 0}, 40};

/// Mean of a pixel's channels, 0 to 255.
double brightness(const Image& image, int x, int y) {
    const std::size_t p = 3 * (static_cast<std::size_t>(y) * image.width + x);
    return (image.pixels[p] + image.pixels[p + 1] + image.pixels[p + 2]) / 3.0;
}

/// Pixel of a world position, counted in pixels from the upper left corner of the picture. By hand, for a
/// camera that looks along −z.
std::array<double, 2> pixel_of(const Vec3d& x, const Camera& camera, const Image& image) {
    const double depth = camera.eye.z() - x.z();
    const double scale = image.height / 2.0 / std::tan(camera.field_of_view / 2 * EIGEN_PI / 180) / depth;
    return {image.width / 2.0 + scale * (x.x() - camera.eye.x()),
            image.height / 2.0 - scale * (x.y() - camera.eye.y())};
}

/// Middle of where two pictures differ, in pixels, and of how many pixels do.
struct Spot {
    double x = 0, y = 0;
    int pixels = 0;
};
Spot difference_of(const Image& a, const Image& b) {
    Spot spot;
    for (int y = 0; y < a.height; ++y)
        for (int x = 0; x < a.width; ++x)
            if (std::abs(brightness(a, x, y) - brightness(b, x, y)) > 3)
                spot.x += x + 0.5, spot.y += y + 0.5, ++spot.pixels;
    spot.x /= std::max(spot.pixels, 1), spot.y /= std::max(spot.pixels, 1);
    return spot;
}

/// What this program prints when it runs only the hidden test of that name, in the given environment.
std::string run_alone(const std::string& environment, const std::string& test) {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    FILE* pipe = popen(("exec env " + environment + " '" + program + "' '" + test + "' 2>&1").c_str(), "r");
    REQUIRE(pipe);
    std::string out;
    char piece[256];
    while (std::fgets(piece, sizeof piece, pipe)) out += piece;
    const int status = pclose(pipe);
    CAPTURE(out);
    CHECK(WIFEXITED(status));
    return out;
}

}  // namespace

TEST_CASE("one particle lands at the pixel its position projects to", "[renderer]") {
    for (const Quality quality : {Quality::draft, Quality::preview, Quality::final}) {
        const auto renderer = renderer_for(small_picture(quality));
        if (!renderer) return;
        const Camera camera{{0.1, 0.2, 1}, {0.1, 0.2, 0}, 40};
        const Image empty = renderer->draw({}, {}, camera, 0);
        for (const Vec3d& x :
             {Vec3d(0.1, 0.2, 0), Vec3d(0.4, 0.4, 0), Vec3d(-0.2, 0.05, 0.3), Vec3d(0.5, 0, -0.5)}) {
            const std::vector<float> one = {float(x.x()), float(x.y()), float(x.z())};
            constexpr float size = 0.06f;
            const Spot spot = difference_of(renderer->draw({one, {}, size}, {}, camera, 0), empty);
            // Its grains lie unevenly about it, over a spacing: their middle within half of one.
            const double margin = 0.5 * size * 45 / std::tan(20 * EIGEN_PI / 180) / (1 - x.z());
            const auto expected = pixel_of(x, camera, empty);
            CAPTURE(int(quality), x.transpose(), spot.x, spot.y, expected[0], expected[1]);
            REQUIRE(spot.pixels > 3);
            CHECK(std::abs(spot.x - expected[0]) < margin);
            CHECK(std::abs(spot.y - expected[1]) < margin);
        }
    }
}

TEST_CASE("a ball covers the disc that its radius projects to", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::final));
    if (!renderer) return;
    const Camera camera{{0, 0, 2}, {0, 0, 0}, 40};
    const Image empty = renderer->draw({}, {}, camera, 0);
    const std::vector<float> particles = ball({0, 0, 0}, 0.4);
    const Spot spot = difference_of(renderer->draw({particles, {}, spacing}, {}, camera, 0), empty);
    // The outline of a ball of radius r at distance d is that of tan = r/√(d² − r²); splats add half of one.
    const double scale = 45 / std::tan(20 * EIGEN_PI / 180), r = 0.4 + 0.5 * spacing;
    const double radius = scale * r / std::sqrt(4 - r * r);
    CHECK(spot.pixels == Approx(EIGEN_PI * radius * radius).epsilon(0.06));
    CHECK(spot.x == Approx(80).margin(0.6));
    CHECK(spot.y == Approx(45).margin(0.6));
}

TEST_CASE("without particles there is the sky, and the ground under it", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const Camera level{{0, 1, 3}, {0, 1, 0}, 40};
    const ParticleView none{{}, {}, spacing};
    const Image sky = renderer->draw(none, {}, level, 0), both = renderer->draw(none, ground, level, 0);
    const std::ptrdiff_t half = 3 * 160 * 44;
    CHECK(std::equal(sky.pixels.begin(), sky.pixels.begin() + half, both.pixels.begin()));
    int unlike = 0;
    for (int y = 48; y < 90; ++y)
        for (int x = 0; x < 160; ++x) unlike += brightness(sky, x, y) != brightness(both, x, y);
    CHECK(unlike > 160 * 42 * 9 / 10);
    CHECK_NOTHROW(renderer->draw({}, {}, level, 0));
}

TEST_CASE("the same particles give the same bytes", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::final));
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.3, 0}, 0.3);
    const ParticleView view{particles, {}, spacing};
    const Image first = renderer->draw(view, ground, front, 0);
    renderer->draw({}, {}, front, 0);
    CHECK(renderer->draw(view, ground, front, 0).pixels == first.pixels);
    Renderer second(small_picture(Quality::final));
    CHECK(second.draw(view, ground, front, 0).pixels == first.pixels);
    CHECK(renderer->draw(view, ground, front, 0).pixels == first.pixels);
}

TEST_CASE("print the hash of a picture", "[.alone]") {
    const std::vector<float> particles = ball({0, 0.3, 0}, 0.3);
    Renderer renderer(small_picture(Quality::final));
    std::uint64_t hash = 14695981039346656037u;
    for (const std::uint8_t byte : renderer.draw({particles, {}, spacing}, ground, front, 0).pixels)
        hash = (hash ^ byte) * 1099511628211u;
    std::cout << "hash " << hash << "\n";
}

TEST_CASE("the number of threads does not change the bytes", "[renderer]") {
    if (!renderer_for(small_picture())) return;
    const auto hash_with = [](const std::string& environment) {
        const std::string out = run_alone(environment, "print the hash of a picture");
        CAPTURE(environment, out);
        REQUIRE(out.find("hash ") != std::string::npos);
        return out.substr(out.find("hash "), 25);
    };
    const std::string one = hash_with("LP_NUM_THREADS=1 OMP_NUM_THREADS=1");
    CHECK(hash_with("LP_NUM_THREADS=3 OMP_NUM_THREADS=2") == one);
    CHECK(hash_with("LP_NUM_THREADS=0 OMP_NUM_THREADS=5") == one);
}

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
    for (const double exposure : {0.0, 0.25, 1.0, 4.0, 1000.0}) {
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

TEST_CASE("particles that are nowhere are not drawn", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    std::vector<float> particles = ball({0, 0.3, 0}, 0.3);
    const Image image = renderer->draw({particles, {}, spacing}, ground, front, 0);
    particles.insert(particles.end(), {NAN, 0, 0, 0, INFINITY, 0, 0, 0, -INFINITY, 3e38f, 3e38f, 3e38f});
    CHECK(renderer->draw({particles, {}, spacing}, ground, front, 0).pixels == image.pixels);
}

TEST_CASE("particles at the camera and behind it do no harm", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const std::vector<float> behind = {0, 0.6f, 2.4f, 0, 0.7f, 4, 0.1f, 0.5f, 3};
    CHECK(renderer->draw({behind, {}, 1e-4f}, ground, front, 0).pixels ==
          renderer->draw({std::span<const float>(), {}, 1e-4f}, ground, front, 0).pixels);
    const std::vector<float> close = {0, 0.59f, 2.35f};
    const Image image = renderer->draw({close, {}, 5.0f}, ground, front, 0);
    CHECK(image.pixels.size() == 3 * 160 * 90);
}

TEST_CASE("a camera may be inside the snow, or look straight down on it", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.3, 0}, 0.3);
    const ParticleView view{particles, {}, spacing};
    CHECK_NOTHROW(renderer->draw(view, ground, {{0, 0.3, 0}, {0, 0.3, -1}, 40}, 0));
    CHECK_NOTHROW(renderer->draw(view, ground, {{0, 0.3, 0}, {0, 0.3, 0}, 40}, 0));
    const Image down = renderer->draw(view, ground, {{0, 3, 0}, {0, 0, 0}, 40}, 0);
    CHECK(brightness(down, 80, 45) > 150);
    CHECK(brightness(down, 80, 45) > brightness(down, 5, 5));
}

TEST_CASE("every kind of collider is drawn where it is, and moves with its velocity", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const Camera camera{{0, 0, 3}, {0, 0, 0}, 40};
    const Image empty = renderer->draw({}, {}, camera, 0);
    const std::vector<Shape> shapes = {Sphere{{0.5, 0.3, 0}, 0.2}, Box{{0.5, 0.3, 0}, {0.3, 0.2, 0.4}},
                                       Cylinder{{0.4, 0.3, 0}, {0.6, 0.3, 0}, 0.2},
                                       Capsule{{0.5, 0.2, 0}, {0.5, 0.4, 0}, 0.1}};
    for (const Shape& shape : shapes) {
        CAPTURE(shape.index());
        Solid collider{{shape}};
        const Spot spot = difference_of(renderer->draw({}, {collider}, camera, 2), empty);
        const auto expected = pixel_of({0.5, 0.3, 0}, camera, empty);
        CHECK(std::abs(spot.x - expected[0]) < 1.5);
        CHECK(std::abs(spot.y - expected[1]) < 1.5);
        collider.velocity = {-0.4, 0, 0};
        const Spot moved = difference_of(renderer->draw({}, {collider}, camera, 2), empty);
        CHECK(std::abs(moved.x - pixel_of({-0.3, 0.3, 0}, camera, empty)[0]) < 1.5);
    }
    CHECK_THROWS_AS(renderer->draw({}, {{{Ellipsoid{}}}}, camera, 0), std::invalid_argument);
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
}

TEST_CASE("a wall hides the snow behind it", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.3, -1}, 0.2);
    const std::vector<Solid> wall = {{{Box{{0, 0.5, 0}, {2, 2, 0.1}}}}};
    const Image without = renderer->draw({}, wall, front, 0);
    CHECK(difference_of(renderer->draw({particles, {}, spacing}, wall, front, 0), without).pixels == 0);
}

TEST_CASE("odd and tiny pictures are drawn", "[renderer]") {
    const std::vector<float> particles = ball({0, 0.3, 0}, 0.1);
    for (const auto& [width, height] : {std::pair(1, 1), {3, 1}, {1, 3}, {33, 17}, {127, 5}})
        for (const Quality quality : {Quality::draft, Quality::final}) {
            Picture picture = small_picture(quality);
            picture.width = width, picture.height = height;
            const auto renderer = renderer_for(picture);
            if (!renderer) return;
            const Image image = renderer->draw({particles, {}, spacing}, ground, front, 0);
            CHECK(image.width == width);
            CHECK(image.height == height);
            CHECK(image.pixels.size() == std::size_t(3) * width * height);
        }
}

TEST_CASE("a picture that OpenGL cannot draw is refused before work starts", "[renderer]") {
    if (!renderer_for(small_picture())) return;
    for (const auto& [width, height] : {std::pair(0, 10), {10, -1}, {1 << 20, 10}, {10, 1 << 20}}) {
        Picture picture = small_picture();
        picture.width = width, picture.height = height;
        CHECK_THROWS_WITH(Renderer(picture), Catch::Contains("pixels"));
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

TEST_CASE("open OpenGL and print what went wrong", "[.alone]") {
    try {
        Renderer renderer(small_picture());
        std::cout << "opened: " << renderer.description() << "\n";
    } catch (const GLError& error) {
        std::cout << "GLError: " << error.what() << "\n";
    }
}

TEST_CASE("where there is no OpenGL, an error says what was tried and what to install", "[renderer]") {
    const std::string test = "open OpenGL and print what went wrong";
    const std::string no_driver = run_alone("__EGL_VENDOR_LIBRARY_DIRS=/nonexistent", test);
    CHECK_THAT(no_driver,
               Catch::Contains("GLError: no OpenGL") && Catch::Contains("apt-get install libegl1"));
    CHECK_THAT(run_alone("FIRN_EGL_DEVICE=99", test), Catch::Contains("FIRN_EGL_DEVICE=99 names no device"));
    CHECK_THAT(run_alone("FIRN_EGL_DEVICE=first", test),
               Catch::Contains("FIRN_EGL_DEVICE=first names no device"));
    // These break Mesa alone: a machine with another driver still draws.
    for (const std::string environment :
         {"LIBGL_DRIVERS_PATH=/nonexistent", "MESA_GL_VERSION_OVERRIDE=3.1 GALLIUM_DRIVER=softpipe"}) {
        CAPTURE(environment);
        const std::string out = run_alone(environment, test);
        CHECK_THAT(out,
                   Catch::Contains("GLError: no usable OpenGL 3.3; tried") || Catch::Contains("opened: "));
        if (out.find("GLError") != std::string::npos)
            CHECK_THAT(out, Catch::Contains("eglInitialize: EGL_") || Catch::Contains("eglCreateContext"));
    }
}
