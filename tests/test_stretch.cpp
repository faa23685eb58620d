#include "sim/stretch.h"
#include "tests/random_matrices.h"

#include <catch2/catch.hpp>

using namespace firn;

namespace {

Symmetric<double> symmetric(const Mat3d& S) { return {S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2)}; }
Mat3d random_symmetric(RandomInput& random) {
    const Mat3d M = random.matrix();
    return M + M.transpose();
}

}  // namespace

TEST_CASE("six numbers reckon as the symmetric matrix that they are", "[stretch]") {
    RandomInput random;
    for (int n = 0; n < 100; ++n) {
        const Mat3d A = random_symmetric(random), B = random_symmetric(random);
        const Vec3d a = random.vector();
        const Symmetric<double> S = symmetric(A);
        REQUIRE((S.squared().matrix() - A * A).norm() < 1e-13 * A.squaredNorm());
        REQUIRE((S.inverse().matrix() * A - Mat3d::Identity()).norm() < 1e-13 * A.norm() * A.inverse().norm());
        REQUIRE((S * a - A * a).norm() < 1e-14 * A.norm() * a.norm());
        REQUIRE(S.squared_norm() == Approx(A.squaredNorm()));
        REQUIRE(S.determinant() == Approx(A.determinant()).margin(1e-12));
        REQUIRE(S.second_invariant() == Approx((A.trace() * A.trace() - (A * A).trace()) / 2).margin(1e-12));
        REQUIRE(positive_definite(S) == (Eigen::SelfAdjointEigenSolver<Mat3d>(A).eigenvalues()(0) > 0));
        REQUIRE(((S + symmetric(B) * 2.0 - Symmetric<double>::identity()).matrix() - (A + 2 * B - Mat3d::Identity())).norm() < 1e-13);
    }
}

TEST_CASE("Jacobi's turns find the eigensystem", "[stretch]") {
    RandomInput random;
    for (int n = 0; n < 500; ++n) {
        Mat3d A = 0.1 * random_symmetric(random);
        if (n % 5 == 0) A = random.rotation() * Vec3d(0.3, 0.3, -0.1).asDiagonal() * Mat3d::Identity();
        if (n % 5 == 1) A.setZero();
        const Eigensystem<double> e = eigensystem(symmetric(A = (A + A.transpose()).eval() / 2));
        REQUIRE((e.Q * e.Q.transpose() - Mat3d::Identity()).norm() < 1e-14);
        REQUIRE((turned(e.Q, e.x).matrix() - A).norm() < 1e-15);
    }
}

TEST_CASE("the left strain is V - I of F = V R, near a rotation and far from one", "[stretch]") {
    RandomInput random;
    using P = Pack<float, lanes>;
    for (int n = 0; n < 500; ++n) {
        const double size = std::pow(10.0, -(n % 8) / 2.0);     // 1 to 3e-4: both ways, and where they meet
        Mat3d strain = random_symmetric(random);
        strain *= (n % 3 == 0 ? 0.0499 : 0.3 * size) / strain.norm();
        const Mat3d F = (Mat3d::Identity() + strain) * random.rotation();
        REQUIRE((left_strain(F).matrix() - strain).norm() < 4e-15);
        Mat3<P> each;
        for (int i = 0; i < 9; ++i) each(i) = P(float(F(i)));
        REQUIRE((left_strain(each).matrix().unaryExpr([](P a) { return double(a[5]); }) - strain).norm() < 1e-6);
    }
    const Mat3d flat = random.rotation() * Vec3d(2, 0.5, 1e-9).asDiagonal() * random.rotation();
    CHECK(Eigen::SelfAdjointEigenSolver<Mat3d>(left_strain(flat).matrix()).eigenvalues()(0) == Approx(1e-9 - 1));
}
