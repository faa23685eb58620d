#include "sim/conjugate_gradient.h"
#include "sim/minres.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include <random>

using namespace firn;

namespace {

struct Vector : Eigen::VectorXd {
    using Eigen::VectorXd::VectorXd;
    using Eigen::VectorXd::operator=;
    void axpy(double a, const Vector& y) { *this += a * y; }
    void scale(double a) { *this *= a; }
    void xpay(double a, const Vector& y) { *this = Eigen::VectorXd(y + a * *this); }
};

struct System {
    Eigen::MatrixXd E;
    Vector b;
    bool by_minres = false;
    Convergence solve(Vector& x, double tolerance, int most) const {
        const auto apply = [&](const Vector& v, Vector& Ev) { Ev = E * v; };
        const auto dot = [](const Vector& u, const Vector& v) { return u.dot(v); };
        const Stopping stop{tolerance, 0, most};
        return by_minres ? minres(x, b, apply, dot, stop) : conjugate_residual(x, b, apply, dot, stop);
    }
};

/// Q diag(eigenvalues) Qᵀ with a random Q.
System system(const Eigen::VectorXd& eigenvalues) {
    std::srand(3);
    const auto n = eigenvalues.size();
    const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(Eigen::MatrixXd::Random(n, n)).householderQ();
    System s;
    s.by_minres = GENERATE(false, true);
    s.E = Q * eigenvalues.asDiagonal() * Q.transpose();
    s.b = Eigen::VectorXd::Random(n);
    return s;
}

}  // namespace

TEST_CASE("a definite system of n unknowns ends in n iterations", "[krylov]") {
    const System s = system(Eigen::VectorXd::LinSpaced(12, 1, 30));
    Vector x = Vector::Zero(12);
    const Convergence c = s.solve(x, 1e-10, 100);
    CHECK(c.converged);
    CHECK(c.iterations <= 13);
    CHECK((s.E * x - s.b).norm() <= 1.01e-10 * s.b.norm());
}

TEST_CASE("an indefinite system is solved too", "[krylov]") {
    Eigen::VectorXd eigenvalues = Eigen::VectorXd::LinSpaced(12, 0.5, 10);
    eigenvalues.head(3) << -0.7, -0.3, -2;
    const System s = system(eigenvalues);
    Vector x = Vector::Zero(12);
    CHECK(s.solve(x, 1e-8, 200).converged);
    CHECK((s.E * x - s.b).norm() < 1e-7 * s.b.norm());
}

TEST_CASE("the residual never grows", "[krylov]") {
    const System s = system(Eigen::VectorXd::LinSpaced(40, 0.01, 100));
    double last = 1;
    for (int most = 1; most < 30; ++most) {
        Vector x = Vector::Zero(40);
        const double now = s.solve(x, 1e-14, most).residual();
        REQUIRE(now <= last * (1 + 1e-12));
        last = now;
    }
}

TEST_CASE("a solve that does not get there says so", "[krylov]") {
    const System s = system(Eigen::VectorXd::LinSpaced(40, 0.01, 100));
    Vector x = Vector::Zero(40);
    const Convergence c = s.solve(x, 1e-10, 5);
    CHECK_FALSE(c.converged);
    CHECK(c.iterations == 5);
    CHECK(c.residual() > 1e-10);
    CHECK(c.residual() == Approx((s.E * x - s.b).norm() / s.b.norm()).epsilon(1e-6));    // the history is in floats
}

TEST_CASE("nothing to solve takes no iteration", "[krylov]") {
    System s = system(Eigen::VectorXd::LinSpaced(5, 1, 2));
    s.b.setZero();
    Vector x = Vector::Zero(5);
    const Convergence c = s.solve(x, 1e-10, 5);
    CHECK(c.iterations == 0);
    CHECK(c.converged);
    CHECK(x.norm() == 0);
}

TEST_CASE("minres goes through where conjugate residuals divide by zero", "[krylov]") {
    System s;
    s.E = Eigen::Vector2d(1, -1).asDiagonal();      // r·E r = 0 for b = (1, 1)
    s.b = Eigen::VectorXd::Ones(2);
    Vector x = Vector::Zero(2);
    const Convergence stuck = s.solve(x, 1e-10, 10);
    CHECK_FALSE(stuck.converged);
    CHECK(std::isfinite(x.norm()));
    s.by_minres = true;
    x = Vector::Zero(2);
    CHECK(s.solve(x, 1e-10, 10).converged);
    CHECK((s.E * x - s.b).norm() < 1e-10);
}

TEST_CASE("both solvers go through the same residuals", "[krylov]") {
    System s = system(Eigen::VectorXd::LinSpaced(20, 0.3, 50));
    std::vector<float> history[2];
    for (const bool by_minres : {false, true}) {
        s.by_minres = by_minres;
        Vector x = Vector::Zero(20);
        history[by_minres] = s.solve(x, 1e-6, 15).history;
    }
    REQUIRE(history[0].size() == history[1].size());
    for (std::size_t i = 0; i < history[0].size(); ++i) CHECK(history[0][i] == Approx(history[1][i]).epsilon(1e-5));
}

TEST_CASE("conjugate gradients leave the residual of what they solved, and what holds the rest", "[krylov]") {
    const int n = 20, held = 4;                     // of the unknowns, which stay as they are
    const System s = system(Eigen::VectorXd::LinSpaced(n, 0.3, 50));
    const auto project = [](Vector& v) { v.head(held).setZero(); };
    const auto apply = [&](const Vector& v, Vector& Ev) { Ev = s.E * v; };
    const auto dot = [](const Vector& u, const Vector& v) { return u.dot(v); };
    Vector x = Vector::Zero(n), r = s.b, b = s.b;
    project(b);
    const Convergence c = conjugate_gradient(x, r, b.norm(), apply, project, dot, Stopping{1e-10, 0, 100});
    CHECK(c.converged);
    CHECK(c.iterations <= n - held + 1);
    CHECK(x.head(held).norm() == 0);
    CHECK((s.b - s.E * x - r).norm() < 1e-12 * s.b.norm());
    CHECK(r.tail(n - held).norm() <= 1.01e-10 * b.norm());
    CHECK(r.head(held).norm() > 0.1);
}
