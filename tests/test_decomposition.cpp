#include "sim/decomposition.h"
#include "tests/random_matrices.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace firn;

namespace {

/// A matrix of one of eight hard kinds, as T holds it.
template <class T> Mat3<T> hard_matrix(RandomInput& random, int kind) {
    Mat3d F = random.matrix();
    switch (kind % 8) {
    case 1: F.col(2) = F.col(1); break;                                 // singular
    case 2: F.col(random.bits() % 3).setZero(); break;
    case 3: F = Mat3d::Identity() + 1e-6 * F; break;                    // all singular values alike
    case 4: F = Mat3d(F.col(0) * F.row(0)); break;                      // rank one
    case 5: F.col(1) *= 1e-15, F.col(2) *= 1e-18; break;                // nearly so
    case 6: F *= sizeof(T) == 8 ? 1e200 : 1e30; break;
    case 7: for (int i = 0; i < 9; ++i) F(i) = static_cast<int>(random.bits() % 3) - 1; break;
    }
    if (kind / 8 % 4 == 1) F *= sizeof(T) == 8 ? 1e-200 : 1e-30;
    return F.cast<T>();
}

}  // namespace

TEMPLATE_TEST_CASE("F = U S V^T with rotations U and V, to a few ulp of its norm", "[decomposition]", float, double) {
    RandomInput random;
    constexpr double epsilon = std::numeric_limits<TestType>::epsilon();
    for (int n = 0; n < 200000; ++n) {
        const Mat3<TestType> F = hard_matrix<TestType>(random, n);
        const Decomposition<TestType> d = decompose(F);
        const Mat3d U = d.U.template cast<double>(), V = d.V.template cast<double>();
        const Vec3d s = d.s.template cast<double>();
        const Mat3d exact = F.template cast<double>();
        const double size = exact.cwiseAbs().maxCoeff();
        CAPTURE(n, exact);
        REQUIRE((U.transpose() * U - Mat3d::Identity()).norm() < 16 * epsilon);
        REQUIRE((V.transpose() * V - Mat3d::Identity()).norm() < 16 * epsilon);
        REQUIRE(std::abs(U.determinant() - 1) < 16 * epsilon);
        REQUIRE(std::abs(V.determinant() - 1) < 16 * epsilon);
        if (size == 0) { REQUIRE(s.norm() == 0); continue; }
        const Mat3d rebuilt = U * (s / size).asDiagonal() * V.transpose();
        REQUIRE((rebuilt - exact / size).norm() < 16 * epsilon * (exact / size).norm());
        REQUIRE(s(0) >= s(1) * (1 - 4 * epsilon));
        REQUIRE(s(1) * (1 + 4 * epsilon) + 4 * epsilon * s(0) >= std::abs(s(2)));
        if (std::abs((exact / size).determinant()) > 100 * epsilon)
            REQUIRE((s(2) < 0) == ((exact / size).determinant() < 0));      // it carries the sign
    }
}

TEST_CASE("a lane of eight is what it is alone", "[decomposition]") {
    RandomInput random;
    for (int n = 0; n < 2000; ++n) {
        Mat3<float> each[8];
        Mat3<Pack<float, 8>> all;
        for (int l = 0; l < 8; ++l) {
            each[l] = hard_matrix<float>(random, n + l * l);
            for (int i = 0; i < 9; ++i) all(i).lanes[l] = each[l](i);
        }
        const auto d = decompose(all);
        for (int l = 0; l < 8; ++l) {
            const auto alone = decompose(each[l]);
            // Fused multiply-add may be used in one and not in the other: not bits, but ulps.
            const float size = std::max(each[l].cwiseAbs().maxCoeff(), 1e-37f);
            for (int i = 0; i < 3; ++i) REQUIRE(std::abs(d.s(i)[l] - alone.s(i)) <= 1e-6f * size);
        }
    }
}

TEST_CASE("not a number goes in and comes out", "[decomposition]") {
    Mat3d F = Mat3d::Identity();
    F(1, 2) = std::nan("");
    CHECK(decompose(F).s.hasNaN());
}

TEST_CASE("the cofactor is the derivative of the determinant", "[decomposition]") {
    RandomInput random;
    for (int n = 0; n < 100; ++n) {
        const Mat3d F = random.matrix(), dF = random.matrix();
        const double h = 1e-6, numeric = (determinant(Mat3d(F + h * dF)) - determinant(Mat3d(F - h * dF))) / (2 * h);
        REQUIRE(cofactor(F).cwiseProduct(dF).sum() == Approx(numeric).margin(1e-8));
        REQUIRE((cofactor(F).transpose() * F - F.determinant() * Mat3d::Identity()).norm() < 1e-13);
    }
}
