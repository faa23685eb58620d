#include "app/commands.h"
#include "app/files.h"
#include "app/machine.h"
#include "render/hash.h"
#include "render/renderer.h"
#include "sim/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>

namespace firn {
namespace {

constexpr double ball_radius = 0.15;  // [m]

struct Subject {
    const char* name;
    Camera camera;
    std::vector<float> x, v;  // [m], [m/s]
    float spacing;            // [m]
};

struct Row {
    const Subject* subject;
    const char* quality;
    std::unique_ptr<Renderer> renderer;
    std::vector<double> wall{}, processor{};  // [s]
};

Subject ball(double count) {
    Subject s{"ball", {{-0.25, 0.35, 0.85}, {0.06, 0.14, 0}, 35}, {}, {}, 0};
    const double h = std::cbrt(4 * M_PI / 3 * ball_radius * ball_radius * ball_radius / count * 8);
    Body body;
    body.shape = Sphere{{0, ball_radius, 0}, ball_radius};
    for (const Vec3d& x : sample(body, 400, h, 1, 0).x)
        for (int a = 0; a < 3; ++a) s.x.push_back(float(x[a]));
    s.v.assign(s.x.size(), 0), s.spacing = float(h / 2);
    return s;
}

// The ball in forty pieces that have slid apart, a thirtieth of its particles thrown out as spray.
Subject heap(const Subject& whole) {
    Subject s = whole;
    s.name = "broken heap", s.camera = {{-0.3, 0.4, 1.0}, {0.03, 0.11, 0}, 35};
    std::vector<Vec3d> seeds;
    for (int i = 0; i < 40; ++i) {
        const double height = 1 - (2 * i + 1) / 40.0, turn = 2.39996 * i,
                     r = ball_radius * std::cbrt((i * 7 % 40 + 1) / 40.0);
        seeds.push_back(r * Vec3d(std::sqrt(1 - height * height) * std::cos(turn), height,
                                  std::sqrt(1 - height * height) * std::sin(turn)));
    }
    for (std::size_t p = 0; p < s.x.size() / 3; ++p) {
        const Vec3d from = Vec3d(s.x[3 * p], s.x[3 * p + 1], s.x[3 * p + 2]) - Vec3d(0, ball_radius, 0);
        const Vec3d seed = *std::min_element(seeds.begin(), seeds.end(), [&](const Vec3d& a, const Vec3d& b) {
            return (a - from).squaredNorm() < (b - from).squaredNorm();
        });
        Vec3d x = Vec3d(0, 0.10, 0) + from + seed.cwiseProduct(Vec3d(0.6, -0.4, 0.6));
        if (const double thrown = 30 * hash_of(std::uint32_t(p)); thrown < 1) {
            const Vec3d v = (2 + 10 * thrown) * from + Vec3d(0, 0.5, 0);
            x += 0.05 * v;
            for (int a = 0; a < 3; ++a) s.v[3 * p + a] = float(v[a]);
        }
        x.y() = std::abs(x.y());
        for (int a = 0; a < 3; ++a) s.x[3 * p + a] = float(x[a]);
    }
    return s;
}

double processor_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

void draw(Row& row, const std::vector<Solid>& solids) {
    const auto start = std::chrono::steady_clock::now();
    const double before = processor_seconds();
    row.renderer->draw({row.subject->x, row.subject->v, row.subject->spacing}, solids, row.subject->camera,
                       0);
    row.processor.push_back(processor_seconds() - before);
    row.wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace

int bench_pictures(const BenchOptions& options) {
    const Subject whole = ball(options.particles), broken = heap(whole);
    const std::vector<Solid> solids = {{Plane{}}, {Box{{0.35, 0.2, 0}, {0.08, 0.4, 0.7}}}};
    std::vector<Row> rows;
    for (const Subject* subject : {&whole, &broken})
        for (const auto& [name, quality] :
             {std::pair("draft", Quality::draft), {"preview", Quality::preview}, {"final", Quality::final}}) {
            Picture picture;
            picture.quality = quality;
            rows.push_back({subject, name, std::make_unique<Renderer>(picture)});
            draw(rows.back(), solids);  // the first use of a shader compiles it
            rows.back().wall.clear(), rows.back().processor.clear();
        }
    for (int round = 0; round < options.rounds; ++round)  // interleaved: a busy machine slows all alike
        for (Row& row : rows) draw(row, solids);

    const Machine machine = this_machine();
    std::string text = fmt::format(
        "{}, {} cores; {}; {} particles, 1280×720, ground and wall, drawing and read-back; of {} "
        "rounds, s a picture\n\n{:<12} {:>8} {:>10} {:>10} {:>12}\n",
        machine.cpu, machine.cores, rows.front().renderer->description(), whole.x.size() / 3, options.rounds,
        "", "", "least", "median", "processor");
    for (Row& row : rows) {
        std::sort(row.wall.begin(), row.wall.end());
        text += fmt::format("{:<12} {:>8} {:>10.3f} {:>10.3f} {:>12.3f}\n", row.subject->name, row.quality,
                            row.wall.front(), row.wall[row.wall.size() / 2],
                            *std::min_element(row.processor.begin(), row.processor.end()));
    }
    print_result(text);
    return 0;
}

}  // namespace firn
