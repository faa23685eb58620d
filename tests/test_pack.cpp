#include "sim/pack.h"

#include <catch2/catch.hpp>

#include <random>

using namespace firn;

namespace {

template <class T> void check_exp(double low, double high) {
    std::mt19937_64 bits(1);
    std::uniform_real_distribution<double> number(low, high);
    double worst = 0;
    for (int n = 0; n < 20000; ++n) {
        Pack<T, 8> a(0);
        for (int l = 0; l < 8; ++l) a.lanes[l] = n == 0 ? T(l - 4) : T(number(bits));
        const Pack<T, 8> e = exp(a);
        for (int l = 0; l < 8; ++l) {
            const double expected = std::exp(double(a[l]));
            worst = std::max(worst, std::abs(double(e[l]) - expected) / expected);
        }
    }
    CHECK(worst < 2 * double(std::numeric_limits<T>::epsilon()));
    const Pack<T, 8> special = exp(Pack<T, 8>::of(0, 1e9, -1e9, std::nan(""), 0, 0, 0, 0));
    CHECK(special[0] == 1);
    CHECK(special[1] > 1e38);
    CHECK(special[2] < 1e-37);
    CHECK(std::isnan(special[3]));
}

}  // namespace

TEST_CASE("eight exponentials at once are the exponential", "[pack]") {
    check_exp<float>(-80, 80);
    check_exp<double>(-36, 36);
}

TEST_CASE("packs go lane by lane", "[pack]") {
    using P = Pack<float, 8>;
    const P a = P::of(0, 1, 2, 3, 4, 5, 6, 7), b = P::of(7.5, 6.5, 5.5, 4.5, 3.5, 2.5, 1.5, -0.5);
    CHECK(any(a < P(1)));
    CHECK_FALSE(any(a < P(0)));
    const P floors = floor(b), smaller = minimum(a, b), mixed = halves(a, b), turned = exchanged(a);
    const auto whole = integers(b);
    const auto low = a < b;
    for (int l = 0; l < 8; ++l) {
        CHECK(floors[l] == std::floor(b[l]));
        CHECK(whole[l] == int(b[l]));
        CHECK(smaller[l] == std::min(a[l], b[l]));
        CHECK(low[l] == (a[l] < b[l]));
        CHECK((!low)[l] == !(a[l] < b[l]));
        CHECK(mixed[l] == (l < 4 ? a[l] : b[l]));
        CHECK(turned[l] == a[(l + 4) % 8]);
        CHECK(doubles(b)[l] == double(b[l]));
    }
}

TEST_CASE("transposing makes rows of columns", "[pack]") {
    std::array<Pack<double, 8>, 8> rows;
    for (int i = 0; i < 8; ++i) for (int j = 0; j < 8; ++j) rows[i].lanes[j] = 10 * i + j;
    transpose(rows);
    for (int i = 0; i < 8; ++i) for (int j = 0; j < 8; ++j) REQUIRE(rows[j][i] == 10 * i + j);
}
