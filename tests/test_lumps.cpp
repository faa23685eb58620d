#include "sim/lumps.h"
#include "sim/simulation.h"
#include "tests/columns.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>

using namespace firn;

namespace {

/// Places in a cube of ten lumps' width.
std::vector<Vec3d> places(int count, double size) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> along(-5 * size, 5 * size);
    std::vector<Vec3d> all(count);
    for (Vec3d& x : all) x = {along(random), along(random), along(random)};
    return all;
}

/// Of J_P at places `apart` from each other [1].
double correlation(const Lumps& lumps, double apart) {
    double a = 0, b = 0, aa = 0, ab = 0;
    const std::vector<Vec3d> all = places(20000, lumps.size);
    const double n = static_cast<double>(all.size());
    for (const Vec3d& x : all) {
        const double here = packed_Jp(lumps, x, 1), there = packed_Jp(lumps, x + Vec3d(apart, 0, 0), 1);
        a += here / n, b += there / n, aa += here * here / n, ab += here * there / n;
    }
    return (ab - a * b) / (aa - a * a);
}

}  // namespace

TEST_CASE("lumps are firm within, weak where they meet, and as wide as is asked for", "[lumps]") {
    const Lumps lumps{0.05, 0.85, 1.2};
    std::vector<double> Jp;
    for (const Vec3d& x : places(20000, lumps.size)) Jp.push_back(packed_Jp(lumps, x, 1));
    std::sort(Jp.begin(), Jp.end());
    CHECK(Jp.front() >= 0.85);
    CHECK(Jp.front() < 0.86);
    CHECK(Jp[Jp.size() / 2] < 1);  // most of it is firm
    CHECK(Jp.back() <= 1.2 + 1e-12);
    CHECK(Jp.back() > 1.19);
    CHECK(correlation(lumps, 0.002) > 0.5);
    CHECK(std::abs(correlation(lumps, 0.05)) < 0.1);
    CHECK(packed_Jp({0.1, 0.85, 1.2}, {0.34, -0.2, 0.62}, 1) == packed_Jp(lumps, {0.17, -0.1, 0.31}, 1));
    CHECK(packed_Jp(lumps, {0.17, -0.1, 0.31}, 1) != packed_Jp(lumps, {0.17, -0.1, 0.31}, 2));
    CHECK(packed_Jp(lumps, {0.0, 0.01, 0.02}, 1) == packed_Jp(lumps, {-0.0, 0.01, 0.02}, 1));
    CHECK(std::isfinite(packed_Jp(lumps, {1e300, -1e20, 0}, 1)));
}

TEST_CASE("lumps have no steps: J_P changes by less than its range over a seam's width", "[lumps]") {
    const Lumps lumps{1, 0, 1};
    const double apart = 0.01, steepest = 1 / 0.028;
    int steps = 0;
    for (const Vec3d& x : places(50000, 1))
        steps += std::abs(packed_Jp(lumps, x + Vec3d(0, apart, 0), 1) - packed_Jp(lumps, x, 1)) >
                 1.001 * steepest * apart;
    CHECK(steps == 0);
}

TEST_CASE("lumps come apart in pieces of many sizes: large ones hold most, small ones are many", "[lumps]") {
    constexpr int n = 108, each = 36;  // places along an edge of the cube, and of a lump's width
    std::vector<char> firm(n * n * n);
    for (int c = 0; c < n * n * n; ++c)
        firm[c] = packed_Jp({each, 0, 1}, Vec3d(c % n, c / n % n, c / n / n), 7) < 0.5;
    double count[3] = {0, 0, 0}, volume[3] = {0, 0, 0};  // of pieces as wide as a lump, half and a quarter
    for (int first = 0; first < n * n * n; ++first) {
        if (!firm[first]) continue;
        std::vector<int> open = {first};
        firm[first] = 0;
        int size = 0;
        for (; !open.empty(); ++size) {
            const int c = open.back();
            open.pop_back();
            for (const int step : {1, n, n * n})
                for (const int to : {c - step, c + step})
                    if (to >= 0 && to < n * n * n && firm[to] &&
                        std::abs(to % n - c % n) + std::abs(to / n % n - c / n % n) < 2)
                        firm[to] = 0, open.push_back(to);
        }
        const double lumps = size / std::pow(each, 3.0);
        if (lumps < 0.0005) continue;  // a few places
        const int kind = lumps > 0.2 ? 0 : lumps > 0.025 ? 1 : 2;
        ++count[kind], volume[kind] += lumps;
    }
    const double all = volume[0] + volume[1] + volume[2];
    CAPTURE(count[0], count[1], count[2], volume[0], volume[1], volume[2]);
    CHECK(std::abs(std::cbrt(volume[0] / count[0]) - 0.85) <
          0.15);  // as wide as is asked for, but for the seams
    CHECK(volume[0] > 0.4 * all);
    CHECK(volume[1] > 0.1 * all);
    CHECK(count[1] > count[0]);
    CHECK(count[2] > 2 * count[1]);
}

TEST_CASE("snow that is packed firmer is as much denser, in the volume that it had", "[lumps]") {
    Body box;
    box.shape = Box{{0, 0, 0}, {0.3, 0.3, 0.3}};
    ParticleSet even = sample(box, 400, 0.05, 1, 0), lumpy = even;
    lumpy.V0 = std::vector<double>(even.size(), 2e-6), lumpy.Jp[3] = 1.5;
    pack_in_lumps(lumpy, {0.2, 0.8, 1.3}, 5);
    CHECK(lumpy.x == even.x);
    for (std::size_t p = 0; p < even.size(); ++p) {
        const double share = packed_Jp({0.2, 0.8, 1.3}, even.x[p], 5);
        REQUIRE(lumpy.Jp[p] == Approx(share * (p == 3 ? 1.5 : 1.0)).epsilon(1e-14));
        REQUIRE(lumpy.m[p] * share == Approx(even.m[p]).epsilon(1e-14));
        REQUIRE(lumpy.V0[p] * share == Approx(2e-6).epsilon(1e-14));
    }
}

TEST_CASE("lumps are as dense as they were packed, rho0/Jp, and step 2 finds that", "[lumps]") {
    const OneThread one;
    Body box;
    box.shape = Box{{0, 0, 0}, {0.4, 0.4, 0.4}};
    box.sampling = Sampling::lattice;
    ParticleSet start = sample(box, 400, 0.02, 1, 0);
    pack_in_lumps(start, {1.5, 0.8, 1.3}, 1);  // wide: the grid sees one lump's middle as it is
    Setup setup;
    setup.h = 0.02, setup.materials = {Snow{}};
    const ParticleRows sampled = make_simulation(setup, ParticleSet(start))->rows(true);
    double volume = 0;  // now, of all
    for (std::size_t p = 0; p < start.size(); ++p) volume += value(sampled, p, "volume") * start.Jp[p];
    CHECK(volume == Approx(0.4 * 0.4 * 0.4).epsilon(1e-6));
    setup.solver.initial_volume = InitialVolume::grid;
    const ParticleRows rows = make_simulation(setup, ParticleSet(start))->rows(true);
    double worst = 0;
    for (std::size_t p = 0; p < start.size(); ++p)
        if (start.x[p].cwiseAbs().maxCoeff() < 0.12)
            worst =
                std::max(worst, std::abs(value(rows, p, "mass") / (value(rows, p, "volume") * start.Jp[p]) /
                                             (400 / start.Jp[p]) -
                                         1));
    CHECK(worst < 0.06);  // a grid smooths what changes within three cells; without J it is 0.074
}

TEST_CASE("a bar of lumps that is pulled gives way at their seams", "[lumps]") {
    const OneThread one;
    Body bar;
    bar.shape = Box{{0, 0, 0}, {0.6, 0.12, 0.12}};
    ParticleSet start = sample(bar, 400, 0.02, 1, 0);
    pack_in_lumps(start, {0.2, 0.85, 1.2}, 1);
    for (std::size_t p = 0; p < start.size(); ++p) start.v[p] = {5 * start.x[p].x(), 0, 0};
    Setup setup;
    setup.h = 0.02, setup.gravity = Vec3d::Zero(), setup.materials = {Snow{}};
    setup.solver.weights = Weights::quadratic;
    const auto sim = make_simulation(setup, ParticleSet(start));
    while (sim->time() < 0.05) sim->step(0.05 - sim->time());
    const ParticleRows rows = sim->rows(true);
    double opened[2] = {0, 0}, count[2] = {0, 0};
    for (std::size_t p = 0; p < start.size(); ++p) {
        if (start.Jp[p] > 0.95 && start.Jp[p] < 1.1) continue;
        const bool seam = start.Jp[p] >= 1.1;
        opened[seam] += std::log(value(rows, p, "Jp") / start.Jp[p]), ++count[seam];
    }
    CAPTURE(count[0], count[1], opened[0] / count[0], opened[1] / count[1]);
    CHECK(opened[1] / count[1] > 0.05);
    CHECK(opened[1] / count[1] > 3 * opened[0] / count[0]);
}

TEST_CASE("an explicit run is expected to take more steps where lumps are firmer", "[lumps]") {
    Setup setup;
    setup.h = 0.01, setup.materials = {Snow{}}, setup.solver.integrator = Integrator::explicit_euler;
    setup.materials[0].xi = 8;
    ParticleSet ball = sample(Body{Sphere{{0, 1, 0}, 0.1}}, 400, setup.h, 1, 0);
    const auto steps = [&] { return estimate_steps(setup, ball, 1); };
    const double loose = steps();
    pack_in_lumps(ball, {0.05, 0.85, 1.2}, 1);
    const double core = *std::min_element(ball.Jp.begin(), ball.Jp.end());
    // The speed of sound goes with exp(ξ (1 − J_P) / 2), and snow packs to 0.8 J_P.
    CHECK(steps() / loose == Approx(std::exp(4 * 0.8 * (1 - core))).epsilon(1e-3));
    CHECK(steps() / loose > 1.5);
}
