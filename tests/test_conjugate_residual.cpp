#include "sim/conjugate_residual.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include <random>

using namespace firn;

namespace {

struct Vector : Eigen::VectorXd {
    using Eigen::VectorXd::VectorXd;
    using Eigen::VectorXd::operator=;
    void axpy(double a, const Vector& y) { *this += a * y; }
    void xpay(double a, const Vector& y) { *this = Eigen::VectorXd(y + a * *this); }
};

struct System {
    Eigen::MatrixXd E;
    Vector b;
    Convergence solve(Vector& x, double tolerance, int most) const {
        const auto apply = [&](const Vector& v) { Vector r; r = E * v; return r; };
        return conjugate_residual(x, b, apply, [](const Vector& u, const Vector& v) { return u.dot(v); }, tolerance, 0.0, most);
    }
};

/// Q diag(eigenvalues) Qᵀ with a random Q.
System system(const Eigen::VectorXd& eigenvalues) {
    std::srand(3);
    const auto n = eigenvalues.size();
    const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(Eigen::MatrixXd::Random(n, n)).householderQ();
    System s;
    s.E = Q * eigenvalues.asDiagonal() * Q.transpose();
    s.b = Eigen::VectorXd::Random(n);
    return s;
}

}  // namespace

TEST_CASE("a definite system of n unknowns ends in n iterations", "[conjugate_residual]") {
    const System s = system(Eigen::VectorXd::LinSpaced(12, 1, 30));
    Vector x = Vector::Zero(12);
    const Convergence c = s.solve(x, 1e-10, 100);
    CHECK(c.converged);
    CHECK(c.iterations <= 13);
    CHECK((s.E * x - s.b).norm() <= 1.01e-10 * s.b.norm());
}

TEST_CASE("an indefinite system is solved too", "[conjugate_residual]") {
    Eigen::VectorXd eigenvalues = Eigen::VectorXd::LinSpaced(12, 0.5, 10);
    eigenvalues.head(3) << -0.7, -0.3, -2;
    const System s = system(eigenvalues);
    Vector x = Vector::Zero(12);
    CHECK(s.solve(x, 1e-8, 200).converged);
    CHECK((s.E * x - s.b).norm() < 1e-7 * s.b.norm());
}

TEST_CASE("the residual never grows", "[conjugate_residual]") {
    const System s = system(Eigen::VectorXd::LinSpaced(40, 0.01, 100));
    double last = 1;
    for (int most = 1; most < 30; ++most) {
        Vector x = Vector::Zero(40);
        const double now = s.solve(x, 1e-14, most).residual;
        REQUIRE(now <= last * (1 + 1e-12));
        last = now;
    }
}

TEST_CASE("a solve that does not get there says so", "[conjugate_residual]") {
    const System s = system(Eigen::VectorXd::LinSpaced(40, 0.01, 100));
    Vector x = Vector::Zero(40);
    const Convergence c = s.solve(x, 1e-10, 5);
    CHECK_FALSE(c.converged);
    CHECK(c.iterations == 5);
    CHECK(c.residual > 1e-10);
    CHECK(c.residual == Approx((s.E * x - s.b).norm() / s.b.norm()).epsilon(1e-10));
}

TEST_CASE("nothing to solve takes no iteration", "[conjugate_residual]") {
    System s = system(Eigen::VectorXd::LinSpaced(5, 1, 2));
    s.b.setZero();
    Vector x = Vector::Zero(5);
    const Convergence c = s.solve(x, 1e-10, 5);
    CHECK(c.iterations == 0);
    CHECK(c.converged);
    CHECK(x.norm() == 0);
}
