#include "tests/small_pictures.h"

#include <algorithm>
#include <set>

using namespace firn;

// What lies around and on top without being asked for.

TEST_CASE("the country around ends nowhere, is uneven, and leaves the sky over it even", "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::preview));
    if (!renderer) return;
    // Along −x, where the angle around jumps from π to −π, and elsewhere.
    for (const Vec3d& towards : {Vec3d(-1, 0.01, 0), Vec3d(0, 0.01, -1)}) {
        const Vec3d eye(0, 0.5, 0);
        const Image near = renderer->draw({}, ground, {eye, eye + towards, 3}, 0);
        double seam = 0, sum = 0;
        for (int x = 1; x < near.width; ++x) {
            double step = 0;
            for (int y = 0; y < near.height; ++y)
                step += std::abs(brightness(near, x, y) - brightness(near, x - 1, y)) / near.height;
            if (2 * x == near.width) seam = step;
            sum += step / near.width;
        }
        CAPTURE(seam, sum);
        CHECK(seam < 3 * sum);

        const Image wide = renderer->draw({}, ground, {eye, eye + towards, 24}, 0);
        std::set<int> seen;
        double high = 0;
        for (int x = 1; x < wide.width; ++x) {
            seen.insert(static_cast<int>(brightness(wide, x, 39)));
            high = std::max(high, std::abs(brightness(wide, x, 4) - brightness(wide, x - 1, 4)));
        }
        CHECK(seen.size() > 10);
        CHECK(high <= 1);
    }
}

TEST_CASE("snow lies in patches on what is level over a ground of snow, on no side, no metal and over no other ground",
          "[renderer]") {
    const auto renderer = renderer_for(small_picture(Quality::preview));
    if (!renderer) return;
    const auto drawn = [&](Look of_ground, const Vec3d& eye, Look of_box = Look::automatic) {
        std::vector<Solid> solids = {{{Plane{}}}, {{Box{{0, 0.5, 0}, {12, 1, 12}}}}};
        solids[0].look = of_ground, solids[1].look = of_box;
        return renderer->draw({{}, {}, spacing}, solids, {eye, {0, 0.5, 0}, 40}, 0);
    };
    const Vec3d over(0, 9, 0.1), beside(0, 0.5, 8);
    const Image bare = drawn(Look::tiles, over), snowy = drawn(Look::snow, over);
    int patches = 0;
    double darker = 0;
    for (int y = 0; y < bare.height; ++y)
        for (int x = 0; x < bare.width; ++x) {
            const double more = brightness(snowy, x, y) - brightness(bare, x, y);
            patches += more > 30;
            darker = std::max(darker, -more);
        }
    CAPTURE(patches);
    CHECK(patches > bare.width * bare.height / 20);
    CHECK(patches < bare.width * bare.height / 2);
    CHECK(darker < 20);  // grains in their own shade
    const Image metal = drawn(Look::snow, over, Look::metal), over_tiles = drawn(Look::tiles, over, Look::metal);
    CHECK(difference_of(metal, over_tiles).pixels == 0);
    // The whole side: only the light that the ground sends up differs. Snow is twice as bright.
    const Image side = drawn(Look::tiles, beside), in_snow = drawn(Look::snow, beside);
    double least = 255, most = 0;
    for (int y = 40; y < 50; ++y)
        for (int x = 2; x < side.width - 2; ++x) {
            const double ratio = brightness(in_snow, x, y) / brightness(side, x, y);
            least = std::min(least, ratio), most = std::max(most, ratio);
        }
    CAPTURE(least, most);
    CHECK(least > 0.95);
    CHECK(most < 1.4);
}
