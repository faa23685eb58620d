#include "render/gl_limits.h"
#include "render/program.h"
#include "tests/small_pictures.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

using namespace firn;

namespace {

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

double darkest(const Image& image) {
    double least = 255;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) least = std::min(least, brightness(image, x, y));
    return least;
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
            // Its grains lie unevenly about it, three quarters of a spacing at most along each axis, and are seen to
            // half a draft's sample.
            const double margin = 0.75 * size * 45 / std::tan(20 * EIGEN_PI / 180) / (1 - x.z()) + 1.25;
            const auto expected = pixel_of(x, camera, empty);
            CAPTURE(int(quality), x.transpose(), spot.x, spot.y, expected[0], expected[1]);
            REQUIRE(spot.pixels > 3);
            CHECK(std::abs(spot.x - expected[0]) < margin);
            CHECK(std::abs(spot.y - expected[1]) < margin);
        }
    }
}

TEST_CASE("a lone particle seen through the narrowest lens is bright", "[renderer]") {
    for (const Quality quality : {Quality::draft, Quality::preview, Quality::final}) {
        const auto renderer = renderer_for(small_picture(quality));
        if (!renderer) return;
        const std::vector<float> one = {0, 0, 0};
        for (const double distance : {1.0, 100.0}) {
            const double field = 1e-4;  // [degrees]
            const float size = float(distance * std::tan(field * EIGEN_PI / 180));
            const Image image = renderer->draw({one, {}, size}, {}, {{0, 0, distance}, {0, 0, 0}, field}, 0);
            int dark = 0;
            for (int y = 0; y < 90; ++y)
                for (int x = 0; x < 160; ++x) dark += brightness(image, x, y) < 40;
            CAPTURE(int(quality), distance);
            CHECK(dark == 0);
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
    std::vector<float> particles = ball({0, 0.3, 0}, 0.3);
    for (int i = 0; i < 400; ++i)  // and spray in front of it
        particles.insert(particles.end(), {0.002f * float(i * 7919 % 400) - 0.4f, 0.0015f * float(i * 104729 % 400), 0.4f});
    const std::vector<float> velocities(particles.size(), 3.0f);
    Renderer renderer(small_picture(Quality::final));
    std::uint64_t hash = 14695981039346656037u;
    for (const std::uint8_t byte : renderer.draw({particles, velocities, spacing}, ground, front, 0).pixels)
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
    CHECK(hash_with("LP_NUM_THREADS=2 OMP_NUM_THREADS=2") == one);
    CHECK(hash_with("LP_NUM_THREADS=4 OMP_NUM_THREADS=3") == one);
    CHECK(hash_with("LP_NUM_THREADS=0 OMP_NUM_THREADS=5") == one);
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
    CHECK(darkest(image) > 30);  // lit snow fills the picture
    CHECK(difference_of(image, renderer->draw({}, ground, front, 0)).pixels > 160 * 90 / 2);
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

TEST_CASE("a wall hides the snow behind it", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.3, -1}, 0.2);
    const std::vector<Solid> wall = {{{Box{{0, 0.5, 0}, {2, 2, 0.1}}}}};
    const Image without = renderer->draw({}, wall, front, 0);
    CHECK(difference_of(renderer->draw({particles, {}, spacing}, wall, front, 0), without).pixels == 0);
}

TEST_CASE("what is near is seen wherever the target is", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const std::vector<float> particles = ball({0, 0.3, 0}, 0.2);
    Camera far = front;
    far.target = front.eye + 500 * (front.target - front.eye);
    const auto ball_in = [&](const Camera& camera) {
        return difference_of(renderer->draw({particles, {}, spacing}, ground, camera, 0), renderer->draw({}, ground, camera, 0));
    };
    CHECK(ball_in(far).pixels == Approx(ball_in(front).pixels).epsilon(0.1));
    const Image empty = renderer->draw({}, ground, far, 0);
    CHECK(brightness(empty, 80, 88) > brightness(renderer->draw({}, {}, far, 0), 80, 88) + 20);  // the ground below
}

TEST_CASE("a body throws its shadow however far it is from the snow", "[renderer]") {
    Picture low = small_picture();
    low.sun_elevation = 12;
    const auto renderer = renderer_for(low);
    if (!renderer) return;
    const Camera above{{24, 12, 6}, {24, 0, 0}, 40};  // 0.11 m a pixel
    const Solid post{{Box{{20, 1, 0}, {0.6, 2, 0.6}}}};
    const auto seen = [&](const std::vector<float>& x, const std::vector<Solid>& solids) {
        return renderer->draw({x, {}, spacing}, solids, above, 0);
    };
    std::vector<float> snow = ball({0, 0.3, 0}, 0.2);
    const auto darkened = [&](const std::vector<float>& x) {  // by more than bodies keep of the sky's light from the ground
        const Image with = seen(x, {ground[0], post}), without = seen(x, ground);
        int pixels = 0;
        for (int j = 0; j < with.height; ++j)
            for (int i = 0; i < with.width; ++i) pixels += brightness(without, i, j) - brightness(with, i, j) > 30;
        return pixels;
    };
    const int alone = darkened(snow);
    CHECK(alone > 400);  // itself, and some 9 m of shade
    CHECK(alone < 1000);
    for (const double x : {14.0, 16.0, 18.0, 19.0}) {  // snow that flies past: the shade has no gaps
        CAPTURE(x);
        CHECK(darkened(ball({x, 2.5, 0.9}, 0.2)) > 0.97 * alone);
    }
    const std::vector<float> more = ball({-30, 0.3, 0}, 0.2);  // snow spreads: the shade stays
    snow.insert(snow.end(), more.begin(), more.end());
    CHECK(darkened(snow) > 0.85 * alone);
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
            CHECK(darkest(image) > 30);  // sky, snow and its ground
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

TEST_CASE("an OpenGL that can do too little is refused by the names of what it lacks", "[renderer]") {
    const GLLimits enough{2048, 2048, 16, 16, 32, 8, 1, 1024, 1024, 60, 16, 63.375f};  // least of any GPU's
    CHECK(missing_in(enough).empty());
    GLLimits poor = enough;
    poor.dual_source_draw_buffers = 0, poor.point_size = 1;
    CHECK(missing_in(poor) == "\n  GL_MAX_DUAL_SOURCE_DRAW_BUFFERS is 0, and 1 are needed for glass"
                              "\n  GL_POINT_SIZE_RANGE is 1, and 60 are needed for splats that are near");
    CHECK_THAT(missing_in({}), Catch::Contains("GL_MAX_3D_TEXTURE_SIZE") && Catch::Contains("GL_MAX_VERTEX_ATTRIBS"));
    if (const auto renderer = renderer_for(small_picture())) CHECK(missing_in(gl_limits()).empty());
}

TEST_CASE("a shader that does not compile shows its file, the line and what is wrong", "[renderer]") {
    const auto renderer = renderer_for(small_picture());  // opens the context
    if (!renderer) return;
    // `faces` is a constant that the program must be given.
    std::ifstream file(FIRN_SOURCE_DIR "/shaders/splat.frag");
    int number = 1, wrong = 0;
    for (std::string line; std::getline(file, line); ++number)
        if (wrong == 0 && line.find("faces ==") != std::string::npos) wrong = number;
    REQUIRE(wrong > 0);
    CHECK_THROWS_WITH(Program({"full_screen.vert"}, {"splat.frag"}),
                      Catch::Contains("common.glsl + splat.frag does not compile") &&
                          Catch::Contains("\nsplat.frag:" + std::to_string(wrong)) &&
                          Catch::Contains("faces"));
    CHECK_THROWS_WITH(Program({"full_screen.vert"}, {"full_screen.vert", "develop.frag"}),
                      Catch::Contains("\nfull_screen.vert:"));
}

TEST_CASE("particles far apart and far from the camera are drawn or left out", "[renderer]") {
    const auto renderer = renderer_for(small_picture());
    if (!renderer) return;
    const Image empty = renderer->draw({}, ground, front, 0);
    for (const float far_away : {1e3f, 9e4f, 1e6f, 3e37f}) {
        CAPTURE(far_away);
        const std::vector<float> two = {-far_away, 0.3f, 0, far_away, 0.3f, 0};
        const Image none = renderer->draw({}, {}, front, 0);
        CHECK(difference_of(renderer->draw({two, {}, spacing}, {}, front, 0), none).pixels < 10);
        std::vector<float> particles = ball({0, 0.3, 0}, 0.2);
        const Image alone = renderer->draw({particles, {}, spacing}, ground, front, 0);
        const Camera afar{{0, 0.6, far_away}, {0, 0.3, 0}, 40};
        CHECK(difference_of(renderer->draw({particles, {}, spacing}, ground, afar, 0),
                            renderer->draw({std::span<const float>(), {}, spacing}, ground, afar, 0)).pixels < 40);  // a spot of a draft's sample
        particles.insert(particles.end(), two.begin(), two.end());
        CHECK(difference_of(renderer->draw({particles, {}, spacing}, ground, front, 0), alone).pixels < 10);
    }
    // A thread of snow is far longer than it is wide.
    std::vector<float> thread;
    for (int i = 0; i < 20000; ++i) thread.insert(thread.end(), {0.01f * float(i) - 100, 0.3f, 0});
    CHECK(difference_of(renderer->draw({thread, {}, 0.01f}, ground, front, 0), empty).pixels > 100);
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
