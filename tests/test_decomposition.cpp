#include "sim/decomposition.h"
#include "tests/random_matrices.h"
#include "tests/sanitizers.h"

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
    using P = Pack<TestType, 8>;
    using D = Pack<double, 8>;                          // what the checks are made in
    constexpr double epsilon = std::numeric_limits<TestType>::epsilon();
    const auto exact = [](const auto& M) {
        Eigen::Matrix<D, std::decay_t<decltype(M)>::RowsAtCompileTime, std::decay_t<decltype(M)>::ColsAtCompileTime> E;
        for (int i = 0; i < M.size(); ++i) for (int l = 0; l < 8; ++l) E(i).lanes[l] = double(M(i)[l]);
        return E;
    };
    const auto largest = [](const D& a) { double m = 0; for (int l = 0; l < 8; ++l) m = std::max(m, a[l]); return m; };
    RandomInput random;
    double skew = 0, handed = 0, off = 0, unsorted = 0;
    int wrong_sign = 0;
    const int packs = sizeof(TestType) == 4 ? tries(1'000'000, 10'000) : tries(250'000, 2'500);  // 10⁷ matrices in all
    for (int n = 0; n < packs; ++n) {
        Mat3<P> F;
        for (int l = 0; l < 8; ++l) {
            const Mat3<TestType> one = hard_matrix<TestType>(random, n + 5 * l);
            for (int i = 0; i < 9; ++i) F(i).lanes[l] = one(i);
        }
        const Decomposition<P> d = decompose(F);
        const Mat3<D> U = exact(d.U), V = exact(d.V);
        D size(0);
        for (int i = 0; i < 9; ++i) size = maximum(size, absolute(exact(F)(i)));
        size = select(size > D(0), size, D(1));
        const Mat3<D> A = exact(F) / size;
        const Vec3<D> s = exact(d.s) / size;
        skew = std::max({skew, largest(Mat3<D>(U.transpose() * U - Mat3<D>::Identity()).squaredNorm()),
                         largest(Mat3<D>(V.transpose() * V - Mat3<D>::Identity()).squaredNorm())});
        handed = std::max({handed, largest(absolute(D(determinant(U) - D(1)))), largest(absolute(D(determinant(V) - D(1))))});
        off = std::max(off, largest(Mat3<D>(U * s.asDiagonal() * V.transpose() - A).squaredNorm() / maximum(D(A.squaredNorm()), D(1e-300))));
        unsorted = std::max({unsorted, largest(s(1) - s(0)), largest(absolute(s(2)) - s(1))});
        const D J = determinant(A);
        for (int l = 0; l < 8; ++l) wrong_sign += std::abs(J[l]) > 100 * epsilon && (s(2)[l] < 0) != (J[l] < 0);
    }
    CHECK(std::sqrt(skew) < 4 * epsilon);
    CHECK(handed < 4 * epsilon);
    CHECK(std::sqrt(off) < 6 * epsilon);
    CHECK(unsorted < 4 * epsilon);
    CHECK(wrong_sign == 0);                             // the smallest singular value carries the sign of det F
}

TEST_CASE("zero decomposes into rotations and nothing", "[decomposition]") {
    const Decomposition<double> d = decompose(Mat3d(Mat3d::Zero()));
    CHECK(d.s.norm() == 0);
    CHECK(determinant(d.U) == 1);
    CHECK(determinant(d.V) == 1);
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
