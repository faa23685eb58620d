#include "render/compare.h"
#include "render/hash.h"
#include "render/png.h"
#include "sim/sampling.h"
#include "tests/small_pictures.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

// Small pictures of the shipped scenes, against those in tests/golden/. Another Mesa, and a GPU, may round
// otherwise: they are compared by how much an eye sees. FIRN_WRITE_GOLDEN=1 writes them anew: look at them then.

using namespace firn;
namespace fs = std::filesystem;

namespace {

/// Mean ꟻLIP, on the driver that drew the golden ones. A sun that is 10° off makes 0.039 to 0.135, no shadow 0.014 to
/// 0.073 in eight of ten. Mesa's softpipe is off by 0.005 to 0.020 and looks the same: llvmpipe filters textures of 8
/// bits with 8 bits.
constexpr double tolerance = 0.01, tolerance_elsewhere = 0.03;

double tolerance_of(const Renderer& renderer) {
    const bool same_driver = renderer.description().find("llvmpipe") != std::string::npos;
    return same_driver ? tolerance : tolerance_elsewhere;
}

struct State {
    std::vector<float> x, v;
    float spacing;
};

struct GoldenPicture {
    std::string name;
    Picture picture;
    State state;
    std::vector<Solid> solids;
    Camera camera;
    std::vector<float> value = {};
};

Solid solid_of(const Shape& shape, Look look = Look::automatic) {
    Solid solid{{shape}};
    solid.look = look;
    return solid;
}

constexpr double grid_spacing = 0.016;  // [m]

/// Bodies at rest on a grid of edge h.
State at_rest(const std::vector<Shape>& shapes, double h) {
    State state{{}, {}, float(h / 2)};
    for (const Shape& shape : shapes)
        for (const Vec3d& x : sample(Body{shape}, 400, h, 1, 0).x)
            for (int a = 0; a < 3; ++a) state.x.push_back(float(x[a])), state.v.push_back(0);
    return state;
}

State ball_at(const Vec3d& center) { return at_rest({Sphere{center, 0.15}}, grid_spacing); }

/// The ball some time after it has hit something at `point`, as if it had burst: its outer parts fly off, the
/// rest lies on the ground about the point. A formula, since a simulation would round otherwise elsewhere.
State burst(State state, const Vec3d& point, double time) {
    for (std::size_t p = 0; 3 * p < state.x.size(); ++p) {
        float *x = &state.x[3 * p], *v = &state.v[3 * p];
        const Vec3d from = Vec3d(x[0], x[1], x[2]) - point;
        const double h = hash_of(std::uint32_t(p)), speed = h < 0.25 ? 9 * h : 0.6 * from.norm() / 0.3;
        const Vec3d way = (from / std::max(from.norm(), 1e-3) + 0.35 * Vec3d(h, 2 * h * h, 0.5 - h)) * speed;
        Vec3d to = Vec3d(x[0], x[1], x[2]) + time * way;
        if (h >= 0.25) to.y() *= 0.45;  // has slumped
        to.y() -= 0.5 * 9.81 * time * time;
        const bool lies = to.y() < 0;
        if (lies) to.y() = 0.012 * h;
        for (int a = 0; a < 3; ++a)
            x[a] = float(to[a]), v[a] = lies ? 0 : float(way[a] - (a == 1 ? 9.81 * time : 0));
    }
    return state;
}

Picture golden_picture(Quality quality = Quality::final) {
    Picture picture = small_picture(quality);
    picture.sun_azimuth = 205, picture.sun_elevation = 28;
    return picture;
}

std::vector<GoldenPicture> golden_pictures() {
    const std::vector<Solid> wall = {solid_of(Plane{}), solid_of(Box{{1.0, 0.28, 0}, {0.2, 0.56, 1.6}})};
    const Camera at_wall{{-0.3, 0.42, 1.9}, {0.84, 0.56, 0}, 29, 0.012};
    const std::vector<Solid> log = {
        solid_of(Plane{}), solid_of(Capsule{{0.06, 0.02, -0.7}, {0.06, 0.02, 1.7}, 0.06}, Look::wood),
        solid_of(Cylinder{{0.07, 0.02, 0.43}, {0.135, 0.115, 0.46}, 0.013}, Look::wood)};
    const Camera at_log{{0.5, 0.3, 1.25}, {0.06, 0.17, 0}, 38, 0.008};
    const State flying = ball_at({0.55, 0.55, 0}),
                at_the_wall = burst(ball_at({0.74, 0.3, 0}), {0.9, 0.3, 0}, 0.12),
                falling = ball_at({0, 0.5, 0}),
                fallen = burst(ball_at({0.05, 0.16, 0}), {0.06, 0.05, 0}, 0.09);
    std::vector<GoldenPicture> all = {{"wall_start", golden_picture(), flying, wall, at_wall},
                                      {"wall_later", golden_picture(), at_the_wall, wall, at_wall},
                                      {"drop_start", golden_picture(), falling, log, at_log},
                                      {"drop_later", golden_picture(), fallen, log, at_log},
                                      {"drop_draft", golden_picture(Quality::draft), fallen, log, at_log}};
    all[3].picture.motion_samples = 2;  // drop_later: its moments share the taps of its lens
    all[4].picture.width *= 2, all[4].picture.height *= 2;  // drop_draft: a sample stands for 2½×2½ pixels
    GoldenPicture bed{"bed_start",
                      golden_picture(),
                      at_rest({Difference{{Ellipsoid{{0, -0.9, 0.1}, {2.9, 1, 2.1}}, Plane{}}},
                               Sphere{{-0.45, 0.3, 0}, 0.12}},
                              0.03),
                      {solid_of(Plane{})},
                      {{0.2, 0.33, 1.45}, {-0.05, 0.21, 0}, 38, 0.01}};
    bed.picture.sun_elevation = 18;
    all.push_back(bed);
    all.push_back({"drop_near", golden_picture(), falling, log, {{0.3, 0.6, 0.5}, {0, 0.5, 0}, 30}});
    GoldenPicture coloured{
        "compression_slice", golden_picture(Quality::preview), falling, {solid_of(Plane{})}, at_log};
    coloured.picture.colour = Colour::compression;
    coloured.picture.slice = Plane{{0, 0, 0.02}, {0, 0, 1}};
    for (std::size_t p = 0; p < falling.x.size(); p += 3) coloured.value.push_back(4 * falling.x[p] + 0.5f);
    all.push_back(coloured);
    GoldenPicture speed{"speed", golden_picture(Quality::preview), fallen, log, at_log};
    speed.picture.colour = Colour::speed;
    for (std::size_t p = 0; p < fallen.v.size(); p += 3)
        speed.value.push_back(std::min(1.0f, std::hypot(fallen.v[p], fallen.v[p + 1], fallen.v[p + 2]) / 3));
    all.push_back(speed);
    GoldenPicture looks{"looks",
                        golden_picture(),
                        ball_at({-0.1, 0.15, 0.3}),
                        {solid_of(Plane{}, Look::tiles)},
                        {{0, 0.8, 2.2}, {0, 0.25, 0}, 38}};
    looks.picture.sun_azimuth = 60, looks.picture.sun_elevation = 15;
    const Look row[] = {Look::ice, Look::soil, Look::wood, Look::concrete, Look::metal, Look::glass};
    for (int i = 0; i < 6; ++i)
        looks.solids.push_back(
            solid_of(Box{{0.32 * i - 0.8, 0.2, 0.1 * (i % 2)}, {0.26, 0.4, 0.26}}, row[i]));
    all.push_back(looks);
    return all;
}

Image drawn(Renderer& renderer, const GoldenPicture& g) {
    return renderer.draw({g.state.x, g.state.v, g.state.spacing, g.value}, g.solids, g.camera, 0);
}

void write_png(const fs::path& path, const Image& image) {
    const auto bytes = encode_png(image, {});
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

fs::path golden_file(const std::string& name) {
    return fs::path(FIRN_SOURCE_DIR) / "tests" / "golden" / (name + ".png");
}

}  // namespace

TEST_CASE("pictures look like the golden ones", "[renderer][golden]") {
    for (const GoldenPicture& golden : golden_pictures()) {
        const auto renderer = renderer_for(golden.picture);
        if (!renderer) return;
        const Image actual = drawn(*renderer, golden);
        if (const char* write = std::getenv("FIRN_WRITE_GOLDEN"); write && std::string(write) == "1")
            write_png(golden_file(golden.name), actual);
        const Image expected = read_png(golden_file(golden.name).string());
        const double flip = compare_images(actual, expected, 0).flip;
        const double allowed = tolerance_of(*renderer);
        const fs::path folder = fs::temp_directory_path() / "firn-golden";
        INFO(golden.name << ": mean FLIP; see " << (folder / golden.name).string()
                         << "-{actual,expected,difference}.png");
        CHECK(flip <= allowed);
        if (flip <= allowed) continue;
        fs::create_directories(folder);
        write_png(folder / (golden.name + "-actual.png"), actual);
        write_png(folder / (golden.name + "-expected.png"), expected);
        write_png(folder / (golden.name + "-difference.png"), heat_map(actual, expected, 0.2));
    }
}

TEST_CASE("golden pictures tell a sun that is 10 degrees off", "[renderer][golden]") {
    for (GoldenPicture golden : golden_pictures()) {
        golden.picture.sun_azimuth += 10;
        const auto renderer = renderer_for(golden.picture);
        if (!renderer) return;
        const double flip =
            compare_images(drawn(*renderer, golden), read_png(golden_file(golden.name).string()), 0).flip;
        CAPTURE(golden.name, flip);
        if (golden.picture.colour == Colour::snow) CHECK(flip > std::max(1.5 * tolerance, 1.25 * tolerance_of(*renderer)));
    }
}
