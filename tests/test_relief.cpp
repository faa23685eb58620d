#include "render/relief.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace firn;

TEST_CASE("the ground's unevenness is level on the whole, however coarse it is seen", "[renderer]") {
    const Relief relief = snow_relief();
    int size = Relief::size;
    for (const auto& level : relief.levels) {
        REQUIRE(level.size() == std::size_t(4 * size * size));
        for (int channel = 0; channel < 3; ++channel) {
            double sum = 0;
            for (std::size_t c = channel; c < level.size(); c += 4) sum += level[c];
            CAPTURE(size, channel);
            CHECK(std::abs(sum / (size * size) - 127.5) <= 0.5 / size + 0.02);
        }
        size /= 2;
    }
    CHECK(size == 0);
}

TEST_CASE("each smaller version of the ground's unevenness is the mean of four of its texels", "[renderer]") {
    const Relief relief = snow_relief();
    int size = Relief::size;
    for (std::size_t l = 1; l < relief.levels.size(); ++l) {
        const auto &fine = relief.levels[l - 1], &coarse = relief.levels[l];
        double off = 0, apart = 0;
        for (int k = 0; k < size; k += 2)
            for (int i = 0; i < size; i += 2)
                for (int channel = 0; channel < 3; ++channel) {
                    const auto at = [&](int a, int b) {
                        return fine[4 * ((k + b) * size + i + a) + channel];
                    };
                    const double mean = (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) / 4.0,
                                 is = coarse[4 * (k / 2 * size / 2 + i / 2) + channel];
                    off += (is - mean) / (0.75 * size * size),
                        apart += std::abs(is - mean) / (0.75 * size * size);
                }
        CAPTURE(size);
        CHECK(apart <= 0.5);
        CHECK(std::abs(off) <= 1.0 / size);  // drivers that cut fractions off would be half a step lower
        size /= 2;
    }
}
