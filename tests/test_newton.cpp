#include "sim/hessian.h"
#include "sim/potential.h"
#include "sim/simulation.h"
#include "tests/columns.h"
#include "tests/random_matrices.h"
#include "tests/report.h"

#include <catch2/catch.hpp>

using namespace firn;

namespace {

constexpr double h = 0.1;

Lame<double> lame() { return {2.0, 3.0}; }

/// Smallest eigenvalue of the pieces.
double lowest(const HessianPieces<double>& p) {
    const Eigen::SelfAdjointEigenSolver<Mat3d> eigen(p.A);
    return std::min({eigen.eigenvalues()(0), p.even.minCoeff(), p.odd.minCoeff()});
}

/// One lane of a differential along ∇u.
template <class Model> Mat3d along(const Model& model, const Mat3d& gradient) {
    using P = Pack<double, lanes>;
    Mat3<P> G;
    for (int i = 0; i < 9; ++i) G(i) = P(gradient(i));
    const Mat3<P> A = model(G);
    Mat3d result;
    for (int i = 0; i < 9; ++i) result(i) = A(i)[3];
    return result;
}

/// A ball that hits the ground or, where stretched, swings in the air.
std::unique_ptr<Simulation> falling(Integrator integrator, double E, double dt, double speed = 3, double stretch = 0) {
    Setup s;
    s.h = h;
    s.materials = {Snow{.E = E}};
    s.solver.integrator = integrator;
    s.solver.precision = Precision::twofold;
    s.solver.weights = Weights::quadratic;
    s.solver.dt = dt;
    s.solver.tolerance = 1e-6;
    s.solver.max_iterations = 200;
    Collider ground;
    ground.shape = Plane{{0, 0, 0}, {0, 1, 0}};
    s.colliders = {ground};
    Body b;
    b.shape = Sphere{{0, 0.32, 0}, 0.3};
    b.velocity = {0.5, -speed, 0};
    if (stretch > 0) {
        s.colliders.clear();
        s.materials[0].theta_s = s.materials[0].theta_c = 0.9;
        s.solver.flip_blend = 1;    // a share of PIC would damp more in more steps
    }
    ParticleSet start = sample(b, 400, h, 1, 0);
    for (Mat3d& F : start.Fe) F = Vec3d(1 + stretch, 1, 1 - stretch / 2).asDiagonal();
    return make_simulation(s, std::move(start));
}

double energy(const Simulation& s) {
    const Totals t = s.totals();
    return t.kinetic + t.elastic + t.potential;
}

}  // namespace

TEST_CASE("in the basis of the singular values, the Hessian is the report's", "[newton]") {
    using P = Pack<double, lanes>;
    RandomInput random;
    for (int n = 0; n < 200; ++n) {
        const Mat3d F = random.rotation() * random.deformation(0.3), G = random.matrix();
        const Elastic<double> e = elastic(F);
        const Mat3d expected = stress_differential(e, lame(), Mat3d(G * F)) * F.transpose();
        Mat3<P> Fp;
        for (int i = 0; i < 9; ++i) Fp(i) = P(F(i));
        const Lame<P> k{P(lame().mu), P(lame().lambda)};
        ProjectedDifferential<P> unprojected(decompose(Fp), Fp, k);
        unprojected.pieces = hessian_pieces(decompose(Fp).s, k);
        REQUIRE((along(unprojected, G) - expected).norm() < 1e-11 * expected.norm());
    }
}

TEST_CASE("projection changes only what is negative, and leaves nothing negative", "[newton]") {
    RandomInput random;
    int indefinite = 0;
    for (int n = 0; n < 2000; ++n) {
        const Vec3d s = decompose(Mat3d(random.matrix())).s;   // inverted ones too
        const HessianPieces<double> p = hessian_pieces(s, lame()), q = projected(p);
        const double size = p.A.norm() + p.even.norm() + p.odd.norm();
        REQUIRE(lowest(q) > -1e-14 * size);
        if (lowest(p) > 0) REQUIRE((q.A - p.A).norm() + (q.even - p.even).norm() + (q.odd - p.odd).norm() < 1e-14 * size);
        indefinite += lowest(p) < 0;
        const Eigen::SelfAdjointEigenSolver<Mat3d> eigen(p.A);  // the nearest one, by another way
        const Mat3d nearest = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
        REQUIRE((q.A - nearest).norm() < 1e-13 * size);
    }
    CHECK(indefinite > 1000);
}

TEST_CASE("compressed snow's Hessian is indefinite by the known amount", "[newton]") {
    // The twist modes at the clamp: 2μ (1 − 2/(2s)) + λ (J − 1) s with s = 1 − θ_c, ν = 0.2: −4.9 % of 2μ.
    const SnowModel<double> m = model(Snow{});
    const HessianPieces<double> p = hessian_pieces(Vec3d(Vec3d::Constant(m.low)), Lame<double>{m.mu0, m.lambda0});
    CHECK(p.odd.minCoeff() / (2 * m.mu0) == Approx(-0.0491).epsilon(0.02));
}

TEST_CASE("Newton and explicit steps agree to first order in the step", "[newton]") {
    const auto last = [](Integrator integrator, double dt) {
        const auto sim = falling(integrator, 1e4, dt, 3, 0.02);
        for (int i = 0; i < std::lround(0.016 / dt); ++i) sim->step(dt);
        return sim->positions();
    };
    const auto gap = [&](double dt) {
        const std::vector<float> a = last(Integrator::explicit_euler, dt), b = last(Integrator::newton, dt);
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i) sum += double(a[i] - b[i]) * (a[i] - b[i]);
        return std::sqrt(sum / double(a.size()));
    };
    const double coarse = gap(5e-4), fine = gap(2.5e-4);
    CHECK(coarse < 1e-3 * h);
    CHECK(coarse / fine == Approx(2).margin(0.35));
}

TEST_CASE("Newton steps of fifty explicit limits stay stable however stiff the snow, and converge", "[newton]") {
    const OneThread one_thread;
    const double E = GENERATE(1e5, 1e7, 1e9);
    const Snow snow{.E = E};
    const double limit = 0.5 * h / std::sqrt((model(snow).lambda0 + 2 * model(snow).mu0) / snow.rho);
    const double dt = std::min(50 * limit, 0.3 * h / 3);
    const auto sim = falling(Integrator::newton, E, dt);
    const double start = energy(*sim);
    int unconverged = 0;
    for (double t = 0; t < 0.12; t += dt) unconverged += !sim->step(dt).converged;
    const Totals sum = sim->totals();
    CHECK(std::isfinite(sum.kinetic + sum.elastic));
    CHECK(energy(*sim) <= start * (1 + 1e-3));
    CHECK(sum.momentum.y() > -0.1 * sum.mass);       // it lies, or jumps; it has not gone through the ground
    CHECK(unconverged == 0);
}

TEST_CASE("one step of Newton's method from rest and without projection is the paper's step", "[newton]") {
    // Where nothing is compressed nothing is cut, and for F_E = I and small v one step is all that is needed.
    const auto paper = falling(Integrator::semi_implicit, 1e5, 1e-4, 1e-3), newton = falling(Integrator::newton, 1e5, 1e-4, 1e-3);
    paper->step(1e-4), newton->step(1e-4);
    const std::vector<float> a = paper->velocities(), b = newton->velocities();
    for (std::size_t i = 0; i < a.size(); ++i) REQUIRE(a[i] == Approx(b[i]).margin(2e-6));
}
