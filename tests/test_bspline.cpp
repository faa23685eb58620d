#include "sim/bspline.h"
#include "tests/random_matrices.h"

#include <catch2/catch.hpp>

using namespace firn;

namespace {

/// Calls f(x_i − x_p, w_ip, ∇w_ip) for every node of a stencil with h = 0.3.
template <Weights kind, class F> void for_each_node(const Vec3d& x, F&& f) {
    const double h = 0.3;
    const Place<kind, double> place(x, h);
    const Stencils<double, kind> s(place.t.template cast<Pack<double, lanes>>(), h);
    for (int i = 0; i < s.width; ++i)
        for (int j = 0; j < s.width; ++j)
            for (int k = 0; k < s.width; ++k) {
                const Vec3d dx = h * (place.base + Vec3d(i, j, k)) - x;
                f(dx, s.N[0][i][3] * s.N[1][j][3] * s.N[2][k][3],
                  Vec3d(s.dN[0][i][3] * s.N[1][j][3] * s.N[2][k][3], s.N[0][i][3] * s.dN[1][j][3] * s.N[2][k][3],
                        s.N[0][i][3] * s.N[1][j][3] * s.dN[2][k][3]));
            }
}

template <Weights kind> void check_moments() {
    RandomInput random;
    const double h = 0.3;
    for (int n = 0; n < 500; ++n) {
        Vec3d x = random.vector();
        if (n % 5 == 0) x = h * (x * 10).array().floor().matrix();          // on a node
        if (n % 5 == 1) x = h * ((x * 10).array().floor() + 0.5).matrix();  // between two
        double sum = 0;
        Vec3d gradients = Vec3d::Zero(), first = Vec3d::Zero();
        Mat3d second = Mat3d::Zero(), linear = Mat3d::Zero();
        for_each_node<kind>(x, [&](const Vec3d& dx, double w, const Vec3d& dw) {
            REQUIRE(w >= 0);
            sum += w;
            gradients += dw;
            first += w * dx;
            second += w * dx * dx.transpose();
            linear += dx * dw.transpose();
        });
        CAPTURE(x);
        REQUIRE(sum == Approx(1).epsilon(1e-13));
        REQUIRE(gradients.norm() < 1e-12);
        REQUIRE(first.norm() < 1e-13);
        REQUIRE((linear - Mat3d::Identity()).norm() < 1e-12);               // ∇ of a linear field is exact
        REQUIRE((second - BSpline<kind>::second_moment * h * h * Mat3d::Identity()).norm() < 1e-13);
    }
}

template <Weights kind> void check_gradients() {
    RandomInput random;
    for (int n = 0; n < 200; ++n) {
        const Vec3d x = random.vector(), d = random.vector();
        const double e = 1e-6;
        const auto field = [&](const Vec3d& at) {                           // Σ_i w_ip q(x_i) with a wild q
            double q = 0;
            for_each_node<kind>(at, [&](const Vec3d& dx, double w, const Vec3d&) { q += w * std::sin(7 * (at + dx).sum()); });
            return q;
        };
        double slope = 0;
        for_each_node<kind>(x, [&](const Vec3d& dx, double, const Vec3d& dw) { slope += std::sin(7 * (x + dx).sum()) * dw.dot(d); });
        REQUIRE(slope == Approx((field(x + e * d) - field(x - e * d)) / (2 * e)).margin(1e-7));
    }
}

}  // namespace

TEST_CASE("weights sum to one, gradients to zero; linear fields and second moments are exact", "[bspline]") {
    check_moments<Weights::cubic>();
    check_moments<Weights::quadratic>();
}

TEST_CASE("gradients are the derivatives of the weights with respect to the particle", "[bspline]") {
    check_gradients<Weights::cubic>();
    check_gradients<Weights::quadratic>();
}

TEST_CASE("cubic weights at a node are 1/6, 2/3, 1/6", "[bspline]") {
    const Place<Weights::cubic, double> place(Vec3d(0.6, -0.3, 0), 0.3);
    const Stencils<double, Weights::cubic> s(place.t.cast<Pack<double, lanes>>(), 0.3);
    CHECK(s.N[2][0][0] == Approx(1.0 / 6));
    CHECK(s.N[2][1][0] == Approx(2.0 / 3));
    CHECK(s.N[2][2][0] == Approx(1.0 / 6));
    CHECK(s.N[2][3][0] == Approx(0).margin(1e-15));
    CHECK(place.base.z() == -1);
}
