#include "render/density.h"
#include "render/light.h"
#include "render/splats.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

using namespace firn;

namespace {

constexpr float spacing = 0.01f;

/// A lattice of n·m·n particles, from the origin upwards.
std::vector<float> block(int n, int m) {
    std::vector<float> x;
    for (int k = 0; k < n; ++k)
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < n; ++i)
                for (const int c : {i, j, k}) x.push_back((static_cast<float>(c) + 0.5f) * spacing);
    return x;
}

Density density_at(const std::vector<float>& x, std::size_t max_cells = 1 << 20) {
    return density_of({x, {}, spacing}, max_cells);
}

const Eigen::Vector3f to_sun(0, 1, 0);

double nothing_near(const Eigen::Vector3f&) { return INFINITY; }

Splats splats_of(const std::vector<float>& x, const Vec3d& eye, const std::vector<float>& v = {},
                 const DistanceToBodies& to_bodies = nothing_near, const SplatDetail& detail = {}) {
    const Density density = density_at(x);
    Density soft = density;
    soft.rho = smoothed(density.rho);
    return visible_splats({x, v, spacing}, density, soft, halved(halved(density)),
                          view_of(Camera{eye, {0.2, 0.2, 0.2}, 40}, {}, 1, 0, 0.01), to_sun, 4, to_bodies, detail);
}

double total(const Density& density) {
    const auto& rho = density.rho.values;
    return std::accumulate(rho.begin(), rho.end(), 0.0) * std::pow(density.cell / spacing, 3);
}

}  // namespace

TEST_CASE("density holds every particle, and is one inside unbroken snow", "[light]") {
    const std::vector<float> x = block(20, 20);
    const Density density = density_at(x);
    CHECK(total(density) == Approx(20 * 20 * 20).epsilon(1e-5));
    CHECK(density.at({0.1f, 0.1f, 0.1f}) == Approx(1).epsilon(1e-3));
    CHECK(density.at({-0.1f, 0.1f, 0.1f}) == 0);
    CHECK(density.at({1e6f, 0, 0}) == 0);
}

TEST_CASE("far, huge and not finite positions neither count nor cost", "[light]") {
    std::vector<float> x = block(30, 30);
    const double before = total(density_at(x));
    x.insert(x.end(), {NAN, 0, 0, INFINITY, 0, 0, 1e30f, 0, 0, -1e8f, 1e8f, 0});
    CHECK(total(density_at(x)) == Approx(before));
    x.insert(x.end(), {9e4f, 0, 0, 0, 9e4f, -9e4f});
    const Density density = density_at(x);
    CHECK(density.rho.values.size() <= 1 << 20);
    CHECK(density.cell == Approx(2 * spacing));
    CHECK(total(density) == Approx(before).epsilon(0.02));  // a thousandth at each side is left out
}

TEST_CASE("the density grid stays within its cells by getting coarser", "[light]") {
    const std::vector<float> x = block(40, 40);
    const Density density = density_at(x, 20000);
    CHECK(density.rho.values.size() <= 20000);
    CHECK(total(density) == Approx(40 * 40 * 40).epsilon(0.05));
}

TEST_CASE("thickness towards the light is the way through snow in spacings", "[light]") {
    const std::vector<float> x = block(40, 40);
    const Density density = density_at(x);
    const auto value = [&](const Field& tau, Eigen::Vector3f at) {
        const Eigen::Vector3i c = ((at - density.origin) / density.cell).array().floor().cast<int>();
        return tau.values[tau.index(c.x(), c.y(), c.z())];
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.0f, 1.0f}) {
            CAPTURE(axis, sign);
            const Field tau = thickness_towards(density, spacing, sign * Eigen::Vector3f::Unit(axis));
            Eigen::Vector3f middle(0.19f, 0.19f, 0.19f), lit = middle, dark = middle;  // cells' centres
            lit[axis] = sign > 0 ? 0.39f : 0.01f, dark[axis] = sign > 0 ? 0.01f : 0.39f;
            CHECK(value(tau, middle) == Approx(20).margin(2));
            CHECK(value(tau, lit) == Approx(0).margin(1.5));
            CHECK(value(tau, dark) == Approx(40).margin(2));
        }
    const Field slanted = thickness_towards(density, spacing, Eigen::Vector3f(1, 1, 0).normalized());
    CHECK(value(slanted, {0.19f, 0.19f, 0.19f}) == Approx(20 * std::sqrt(2)).margin(3));
    CHECK(value(slanted, {0.39f, 0.39f, 0.19f}) == Approx(0).margin(3));
}

TEST_CASE("the deeper in snow, the less sun and sky, and blue goes farthest", "[light]") {
    const std::vector<float> x = block(40, 40);
    const Density density = density_at(x);
    const auto light = light_in_snow(density, spacing, {0, 1, 0});
    float sun = 2, sky = 2;
    for (const float y : {0.47f, 0.37f, 0.25f, 0.13f, 0.03f}) {
        CAPTURE(y);
        const Eigen::Vector3f at(0.19f, y, 0.19f);
        const Eigen::Vector3i c = ((at - density.origin) / density.cell).array().floor().cast<int>();
        const SnowLight here = light[density.rho.index(c.x(), c.y(), c.z())];
        CHECK(here.sun[1] < sun);
        CHECK(here.sky < sky);
        CHECK(here.sun[0] <= here.sun[2]);
        sun = here.sun[1], sky = here.sky;
    }
    CHECK(sun < 0.35f);
    CHECK(light[0].sun[1] == Approx(1));
    CHECK(light[0].sky > 0.5f);
}

TEST_CASE("what lies deep inside is not drawn, and nothing of the surface is missing", "[light]") {
    const int n = 40;
    const std::vector<float> x = block(n, n);
    const Splats visible = splats_of(x, {0.2, 0.2, 9});
    const auto& splats = visible.all;
    const std::size_t seen = visible.seen;
    CHECK(seen < splats.size());
    CHECK(seen > splats.size() / 8);
    CHECK(splats.size() < n * n * n / 2);
    std::size_t front = 0, top = 0;
    for (std::size_t i = 0; i < splats.size(); ++i) {
        CHECK(splats[i].radius > 0);
        front += i < seen && splats[i].z > (n - 1) * spacing;
        top += i >= visible.far_lit && splats[i].y > (n - 1) * spacing;
    }
    CHECK(visible.near == 0);
    CHECK(front == n * n);
    CHECK(top == n * n);  // all that the sun reaches throws a shadow
}

TEST_CASE("where particles are small, some of them cover as much as all would", "[light]") {
    const std::vector<float> x = block(40, 40);
    const Density density = density_at(x);
    Density soft = density;
    soft.rho = smoothed(density.rho);
    const View view = view_of(Camera{{0.2, 0.2, 30}, {0.2, 0.2, 0.2}, 40}, {}, 1, 0, 0.01);
    const auto area = [&](float least_radius, std::size_t& count) {
        double sum = 0;
        count = 0;
        for (const Splat& s : visible_splats({x, {}, spacing}, density, soft, halved(halved(density)), view,
                                             to_sun, 4, nothing_near, {least_radius})
                                  .all)
            if (s.hash != 0.5f) sum += s.radius * s.radius, ++count;  // 0.5: plugs, which are not particles
        return sum;
    };
    std::size_t all = 0, some = 0;
    const double covered = area(0, all);
    const float wanted = 0.85f * spacing / (view.sample_tan * 29.8f);  // radius of a particle [samples]
    CHECK(area(2 * wanted, some) == Approx(covered).epsilon(0.05));
    CHECK(double(some) == Approx(0.25 * double(all)).epsilon(0.05));
    area(0.9f * wanted, some);
    CHECK(some == all);
}

TEST_CASE("a grain is a crumb where it lies or slides, and powder where it flies, turning round too",
          "[light]") {
    const std::vector<float> x = {0.1f, 0.1f, 0.1f};  // one that is no crumb: five of six are none
    const auto amount = [&](float speed, double height) {  // in the air: 1 and no splat; else a half
        const Splats splats = splats_of(x, {0.2, 0.2, 2}, {speed, 0, 0}, [&](const auto&) { return height; });
        REQUIRE(splats.spray.size() == 1);
        CHECK(splats.all.size() == (splats.spray[0].amount < 0.9f ? 1 : 0));
        return splats.spray[0].amount;
    };
    const float slow = 0.1f * spacing, sliding = 100 * spacing, fast = 1000 * spacing;  // [m/s]
    for (const double near : {0.0, 1.9 * spacing}) {
        CHECK(amount(slow, near) == Approx(0.5));
        CHECK(amount(sliding, near) == Approx(0.5));
        CHECK(amount(fast, near) == Approx(1));
    }
    for (const float speed : {slow, sliding, fast}) CHECK(amount(speed, 5 * spacing) == Approx(1));
}

TEST_CASE("in flying powder are crumbs as of what breaks: a quarter of them is twice as wide", "[light]") {
    std::vector<float> x = block(30, 30);
    for (float& c : x) c *= 8;
    const Splats splats = splats_of(x, {0, 0, 30}, std::vector<float>(x.size(), 3.0f));
    const auto wider_than = [&](float spacings) {
        return double(std::count_if(splats.all.begin(), splats.all.end(),
                                    [&](const Splat& s) { return s.radius > spacings * spacing; }));
    };
    const double particles = 30 * 30 * 30;
    CHECK(splats.spray.size() == particles);  // each has powder about it
    CHECK(wider_than(0.2f) / wider_than(0.1f) == Approx(0.25).epsilon(0.25));
    CHECK(wider_than(0.1f) > 0.04 * particles);
    CHECK(wider_than(0) < 0.2 * particles);
    CHECK(wider_than(0.62f) == 0);  // none holds more than its particle
}

TEST_CASE("a crumb that is drawn as a grain throws one shade: its powder's, or else its own", "[light]") {
    for (const float apart : {3.0f, 8.0f}) {
        std::vector<float> x = block(20, 20);
        for (float& c : x) c *= apart;
        SplatDetail detail;
        detail.crumb = 1e6f;  // all of them
        const Splats splats = splats_of(x, {0, 0, 30}, std::vector<float>(x.size(), 3.0f), nothing_near, detail);
        std::size_t crumbs = 0, without_powder = 0;
        for (const SprayPoint& s : splats.spray)
            crumbs += s.crumb > 0, without_powder += s.crumb > 0 && s.powder <= 0.01f;
        CAPTURE(apart, crumbs);
        CHECK(splats.seen == 0);
        CHECK(splats.all.size() == without_powder);
        if (apart > 4) CHECK(without_powder == crumbs);
        if (apart < 4) CHECK(without_powder < 0.1 * crumbs);  // at its rim
        CHECK(crumbs > 0.1 * 20 * 20 * 20);
    }
}

TEST_CASE("cells grow by a fifth where there are too many, and a lump stays as firm", "[light]") {
    std::vector<float> x = block(4, 4);
    for (const float far : {-0.5f, 0.5f}) x.insert(x.end(), {far, far, far});
    const auto firm = [&](const Density& density) {
        Density soft = density;
        soft.rho = smoothed(density.rho);
        double radii = 0;
        for (const Splat& s :
             visible_splats({x, {}, spacing}, density, soft, halved(halved(density)),
                            view_of(Camera{{0, 0, 1}, {0, 0, 0}, 40}, {}, 1, 0, 0.01), to_sun, 4, nothing_near)
                 .all)
            radii += s.radius;
        return radii;
    };
    const Density all = density_at(x);
    Density before = all;
    for (std::size_t most = all.rho.values.size(); before.cell < 1.9f * all.cell; most = most * 9 / 10) {
        const Density density = density_at(x, most);
        CHECK(density.rho.values.size() <= most);
        CHECK(density.cell < 1.2f * before.cell);
        CHECK(firm(density) == Approx(firm(before)).epsilon(0.15));
        before = density;
    }
}

TEST_CASE("powder spreads to its neighbours, hides no more for it, and where it is thin nothing", "[light]") {
    float dense = 0, sparse = INFINITY;
    for (const int apart : {2, 3, 4, 8}) {
        std::vector<float> x = block(12, 12);
        for (float& c : x) c *= static_cast<float>(apart);
        const Splats splats = splats_of(x, {0, 0, 9}, std::vector<float>(x.size(), 3.0f));
        float radius = 0, hidden = 0;  // means; hidden: πr² times opacity, but for π
        for (const SprayPoint& s : splats.spray) {
            CHECK(s.powder <= s.amount);
            radius += s.puff, hidden += s.puff * s.puff * s.powder;
        }
        const auto count = static_cast<float>(splats.spray.size());
        REQUIRE(count > 1000);
        INFO(apart << " spacings apart: " << radius / count / spacing << ", " << hidden / count);
        CHECK(radius / count >= dense);
        CHECK(hidden / count <= sparse);
        if (apart == 3) CHECK(hidden / count > 0.6f * sparse);  // it does not vanish while it spreads
        dense = radius / count, sparse = hidden / count;
    }
    CHECK(sparse == 0);
    CHECK(dense > 2 * 1.9f * spacing);
}

TEST_CASE("a single particle is spray in flight and a crumb at rest, unbroken snow is neither", "[light]") {
    const std::vector<float> one = {0.3f, 0.2f, 0.1f};
    const Splats crumb = splats_of(one, {0, 0, 9});
    REQUIRE(crumb.all.size() == 1);
    CHECK(crumb.all[0].radius < 0.8f * spacing);
    const Splats alone = splats_of(one, {0, 0, 9}, {3, 0, 0});
    CHECK(alone.all.empty());
    REQUIRE(alone.spray.size() == 1);
    CHECK(alone.spray[0].x == 0.3f);
    CHECK(alone.spray[0].amount == 1);
    CHECK(alone.spray[0].vx == 3);
    const std::vector<float> whole = block(20, 20);
    CHECK(splats_of(whole, {0, 0, 9}).spray.empty());
    CHECK(splats_of(whole, {0, 0, 9}, std::vector<float>(whole.size(), 3.0f)).spray.size() <=
          8);  // its corners
    CHECK(splats_of({}, {0, 0, 9}).all.empty());
}

TEST_CASE("what flies outside of the density is spray without powder", "[light]") {
    std::vector<float> x = block(30, 30);
    for (const float c : {5e4f, 0.1f, 0.1f}) x.push_back(c);
    const Splats splats = splats_of(x, {0, 0, 9}, std::vector<float>(x.size(), 3.0f));
    REQUIRE_FALSE(splats.spray.empty());
    CHECK(splats.spray.back().x == 5e4f);
    for (const SprayPoint& s : splats.spray) CHECK((s.powder >= 0 && s.powder <= s.amount));
    CHECK(splats.spray.back().powder == 0);
}

TEST_CASE("a splat is covered by the lump in front of it, not by what is behind or beside it", "[light]") {
    const std::vector<float> x = block(40, 40);
    const Cover cover(density_at(x));
    const Eigen::Vector3f eye(0.2f, 0.2f, 2);
    CHECK(is_covered({0.2f, 0.2f, 0.01f}, eye, cover));
    CHECK(is_covered({0.2f, 0.2f, -0.1f}, eye, cover));  // anywhere behind it
    CHECK_FALSE(is_covered({0.2f, 0.2f, 0.39f}, eye, cover));
    CHECK_FALSE(is_covered({0.2f, 0.39f, 0.2f}, {0.2f, 3, 0.2f}, cover));
    CHECK_FALSE(is_covered({0.5f, 0.2f, 0.01f}, eye, cover));
    CHECK_FALSE(is_covered({0.2f, 0.2f, 0.2f}, {0.2f, 0.2f, 0.25f}, cover));  // the eye is inside, too
    CHECK_FALSE(is_covered({0.2f, 0.4f, 0.01f}, {0.2f, 0.4f, 2}, cover));     // one may look along a face
}

TEST_CASE("sight ends after two cells of unbroken snow, not before", "[light]") {
    for (int rows = 1; rows <= 12; ++rows) {  // two of which are a cell
        CAPTURE(rows);
        const Cover cover(density_at(block(40, rows)));
        const bool covered = is_covered({0.21f, -0.05f, 0.21f}, {0.21f, 2, 0.21f}, cover);
        if (rows <= 4) CHECK_FALSE(covered);
        if (rows >= 6) CHECK(covered);
    }
}

TEST_CASE("unbroken snow lets next to no ray through, however its particles lie", "[light]") {
    std::mt19937 random(1);
    std::vector<float> x(3 * 40 * 40 * 40);
    for (float& c : x) c = 0.4f * static_cast<float>(random() % 4096) / 4096;
    const Splats splats = splats_of(x, {0.2, 0.2, 9});
    // Where rays to the front, but for its rim, pass: each splat, seen from the eye, is a disc on it.
    constexpr int n = 200;
    constexpr float width = 0.3f;
    const auto middle = [](int i) { return width * ((static_cast<float>(i) + 0.5f) / n - 0.5f); };
    std::vector<bool> stopped(n * n);
    for (std::size_t s = 0; s < splats.seen; ++s) {
        const Splat& splat = splats.all[s];
        const float scale = 8.6f / (9 - splat.z), radius = scale * splat.radius;
        const float x_there = scale * (splat.x - 0.2f), y_there = scale * (splat.y - 0.2f);
        for (int j = 0; j < n; ++j)
            for (int i = 0; i < n; ++i)
                if (std::hypot(middle(i) - x_there, middle(j) - y_there) < radius) stopped[j * n + i] = true;
    }
    const auto through = std::count(stopped.begin(), stopped.end(), false);
    CHECK(double(through) / (n * n) < 0.002);  // without plugs 0.012
}

TEST_CASE("positions that are not finite, or too far for a float, give no splat", "[light]") {
    const std::vector<float> bad = {NAN, 0, 0, 0, INFINITY, 0, 0, 0, -INFINITY, 3e38f, 0, 0, 0, -2e5f, 0};
    CHECK(splats_of(bad, {0, 0, 9}).all.empty());
}
