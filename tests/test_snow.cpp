#include "sim/snow.h"
#include "tests/random_matrices.h"
#include "tests/report.h"

#include <catch2/catch.hpp>

using namespace firn;

namespace {

const Lame<double> lame{58333, 38889};  // [Pa], the default snow's

double psi(const Mat3d& F) { return energy_density(elastic(F), lame); }
Mat3d P(const Mat3d& F) { return stress(elastic(F), lame); }

}  // namespace

TEST_CASE("energy and stress vanish at every rotation", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 100; ++n) {
        const Mat3d R = random.rotation();
        REQUIRE(psi(R) < 1e-24);
        REQUIRE(P(R).norm() < 1e-9);
    }
}

TEST_CASE("energy does not see a rotation of the world, stress turns with it", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 100; ++n) {
        const Mat3d F = random.deformation(), Q = random.rotation();
        REQUIRE(psi(Q * F) == Approx(psi(F)).epsilon(1e-12));
        REQUIRE((P(Q * F) - Q * P(F)).norm() < 1e-9);
    }
}

TEST_CASE("P is the derivative of the energy", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 200; ++n) {
        const Mat3d F = random.deformation(), dF = random.matrix();
        const double h = 1e-5;      // error of the scheme: h² ‖Ψ'''‖ + ε Ψ / h ≈ 1e-10 λ
        const double numeric = (psi(F + h * dF) - psi(F - h * dF)) / (2 * h);
        CAPTURE(F, dF);
        REQUIRE(std::abs(P(F).cwiseProduct(dF).sum() - numeric) < 1e-7 * lame.mu);
    }
}

TEST_CASE("dP is the derivative of P", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 200; ++n) {
        const Mat3d F = random.deformation(), dF = random.matrix();
        const double h = 1e-5;
        const Mat3d numeric = (P(F + h * dF) - P(F - h * dF)) / (2 * h);
        CAPTURE(F, dF);
        REQUIRE((stress_differential(elastic(F), lame, dF) - numeric).norm() < 1e-7 * lame.mu * dF.norm());
    }
}

TEST_CASE("d(cof F) is the derivative of the cofactor", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 100; ++n) {
        const Mat3d F = random.matrix(), dF = random.matrix();
        // cof is quadratic in F: a central difference is exact but for round-off, ε ‖cof F‖ / h.
        const double h = 1e-3;
        const Mat3d numeric = (cofactor(Mat3d(F + h * dF)) - cofactor(Mat3d(F - h * dF))) / (2 * h);
        REQUIRE((cofactor_differential(F, dF) - numeric).norm() < 1e-11);
    }
}

TEST_CASE("dP is the derivative of P to the fourth order of the differences", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 100; ++n) {
        const Mat3d F = random.deformation(0.05), dF = random.matrix().normalized();
        // Error of the scheme: h⁴ ‖P⁽⁵⁾‖ ≈ 1e-12 μ, round-off ε ‖P‖ / h ≈ 1e-13 μ at h = 1e-3.
        const double h = 1e-3;
        const auto difference = [&](double e) { return Mat3d((P(F + e * dF) - P(F - e * dF)) / (2 * e)); };
        const Mat3d numeric = (4 * difference(h) - difference(2 * h)) / 3;
        CAPTURE(F, dF);
        REQUIRE((stress_differential(elastic(F), lame, dF) - numeric).norm() < 2e-10 * lame.mu);
    }
}

TEST_CASE("dP is symmetric", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 200; ++n) {
        const Elastic<double> e = elastic(random.deformation());
        const Mat3d a = random.matrix(), b = random.matrix();
        const double ab = stress_differential(e, lame, a).cwiseProduct(b).sum();
        const double ba = stress_differential(e, lame, b).cwiseProduct(a).sum();
        REQUIRE(ab == Approx(ba).epsilon(1e-12).margin(1e-12 * lame.mu));
    }
}

TEST_CASE("dR is the derivative of the rotation, and stays tangent to it", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 200; ++n) {
        const Mat3d F = random.deformation(), dF = random.matrix();
        const Elastic<double> e = elastic(F);
        const Mat3d dR = rotation_differential(e.R, rotation_system_inverse(e.S), dF);
        const double h = 1e-6;
        const Mat3d numeric = (elastic(Mat3d(F + h * dF)).R - elastic(Mat3d(F - h * dF)).R) / (2 * h);
        REQUIRE((dR - numeric).norm() < 1e-8 * dF.norm());
        const Mat3d K = e.R.transpose() * dR;
        REQUIRE((K + K.transpose()).norm() < 1e-12 * dF.norm());
    }
}

TEST_CASE("compressed snow has three soft modes, as deep as theory says", "[snow]") {
    // Twists of F = s I: eigenvalue 2μ (1 − 1/s) + λ (J − 1) s, −5765 Pa at the clamp.
    const Elastic<double> e = elastic(Mat3d(0.975 * Mat3d::Identity()));
    Mat3d twist = Mat3d::Zero();
    twist(0, 1) = 1 / std::sqrt(2.0), twist(1, 0) = -twist(0, 1);
    CHECK(stress_differential(e, lame, twist).cwiseProduct(twist).sum() == Approx(-5765).epsilon(1e-3));
}

TEST_CASE("the Kirchhoff stress is P F^T", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 100; ++n) {
        const Mat3d F = random.deformation();
        REQUIRE((kirchhoff_stress(left_strain(F), lame).matrix() - P(F) * F.transpose()).norm() < 1e-12 * lame.mu);
    }
}

TEST_CASE("in the frame of the world, dR and dP F^T are the report's", "[snow]") {
    RandomInput random;
    for (int n = 0; n < 200; ++n) {
        const Mat3d F = random.rotation() * random.deformation(n % 2 ? 0.3 : 0.01), G = random.matrix();
        const Elastic<double> e = elastic(F);
        const Mat3d dR = rotation_differential(e.R, rotation_system_inverse(e.S), Mat3d(G * F));
        const KirchhoffDifferential<double> d(left_strain(F), lame);
        const Vec3d omega = rotation_differential(d.K, Mat3d(G * d.V.matrix()));
        REQUIRE((cross_matrix(omega) * e.R - dR).norm() < 1e-12 * G.norm() * d.K.matrix().norm());
        const Mat3d expected = stress_differential(e, lame, Mat3d(G * F)) * F.transpose();
        REQUIRE((d(G) - expected).norm() < 1e-11 * expected.norm());
    }
}

TEST_CASE("compaction hardens by exp(xi (1 - Jp)) and the defaults are the paper's", "[snow]") {
    const SnowModel<double> s = model(Snow{});
    CHECK(s.mu0 == Approx(58333.3).epsilon(1e-5));
    CHECK(s.lambda0 == Approx(38888.9).epsilon(1e-5));
    CHECK(hardened(s, 1.0).mu == Approx(s.mu0));
    CHECK(hardened(s, 0.9).lambda == Approx(s.lambda0 * std::exp(1.0)));
    CHECK(hardened(s, 1.1).mu == Approx(s.mu0 * std::exp(-1.0)));
}

TEST_CASE("the return mapping keeps F_E F_P, clips at its limits and is idempotent", "[snow]") {
    RandomInput random;
    const SnowModel<double> s = model(Snow{});
    for (int n = 0; n < 500; ++n) {
        const Mat3d trial = random.deformation(0.03);
        const double Jp = 0.9 + 0.2 * std::abs(std::sin(n));
        const Returned<double> r = return_map(s, trial, Jp);
        REQUIRE(r.Fe.determinant() * r.Jp == Approx(trial.determinant() * Jp).epsilon(1e-13));
        const Vec3d sigma = decompose(r.Fe).s;
        REQUIRE(sigma.maxCoeff() <= s.high * (1 + 1e-14));
        REQUIRE(sigma.minCoeff() >= s.low * (1 - 1e-14));
        REQUIRE((r.tau.matrix() - stress(elastic(r.Fe), hardened(s, r.Jp)) * r.Fe.transpose()).norm() < 1e-9 * s.mu0);
        // The rotation of the trial state is kept: only stretches are cut.
        REQUIRE((elastic(r.Fe).R - elastic(trial).R).norm() < 1e-12);
        const Returned<double> again = return_map(s, r.Fe, r.Jp);
        REQUIRE((again.Fe - r.Fe).norm() < 1e-14);
        REQUIRE(again.Jp == Approx(r.Jp).epsilon(1e-14));
    }
}

TEST_CASE("what needs no cut is kept to the bit", "[snow]") {
    RandomInput random;
    const SnowModel<double> s = model(Snow{});
    for (int n = 0; n < 100; ++n) {
        const Mat3d trial = random.rotation() * (Mat3d::Identity() + 1e-4 * random.matrix());
        const Returned<double> r = return_map(s, trial, 0.95);
        REQUIRE(r.Fe == trial);
        REQUIRE(r.Jp == 0.95);
    }
}

TEST_CASE("snow packed to max_density takes the rest of a compression elastically, and shears as before", "[snow]") {
    RandomInput random;
    const SnowModel<double> s = model(Snow{}), paper = model(Snow{.max_density = 1e9});
    int packed = 0;
    for (int n = 0; n < 2000; ++n) {
        const Mat3d trial = std::exp(0.2 * random.number() - 0.1) * random.deformation(0.03);
        const double Jp = s.Jp_min * (n % 4 == 0 ? 1 : std::exp(0.2 * std::abs(random.number())));
        const Returned<double> r = return_map(s, trial, Jp), free = return_map(paper, trial, Jp);
        CAPTURE(n, trial, Jp);
        REQUIRE(r.Fe.determinant() * r.Jp == Approx(trial.determinant() * Jp).epsilon(1e-13));
        if (free.Jp >= s.Jp_min) {
            REQUIRE(r.Fe == free.Fe);
            REQUIRE(r.Jp == free.Jp);
            continue;
        }
        ++packed;
        REQUIRE(r.Jp == s.Jp_min);
        const Vec3d sigma = decompose(r.Fe).s;
        REQUIRE(sigma(0) <= s.high * (1 + 1e-14));
        REQUIRE(sigma(0) / sigma(2) <= s.high / s.low * (1 + 1e-13));
        REQUIRE((r.tau.matrix() - stress(elastic(r.Fe), hardened(s, r.Jp)) * r.Fe.transpose()).norm() < 1e-9 * r.k.mu);
        REQUIRE((elastic(r.Fe).R - elastic(trial).R).norm() < 1e-12);
        const Returned<double> again = return_map(s, r.Fe, r.Jp);
        REQUIRE((again.Fe - r.Fe).norm() < 1e-14);
        REQUIRE(again.Jp == r.Jp);
        const Mat3d Q = random.rotation(), W = random.rotation();
        REQUIRE((return_map(s, Mat3d(Q * trial * W), Jp).Fe - Q * r.Fe * W).norm() < 1e-13);
        if (Jp == s.Jp_min && decompose(trial).s(2) > 0.5)
            REQUIRE(r.energy_density <= energy_density(elastic(trial), r.k) * (1 + 1e-12));
    }
    CHECK(packed > 500);
}

TEST_CASE("the return mapping has no jump, where snow becomes as dense as it can be or elsewhere", "[snow]") {
    RandomInput random;
    const SnowModel<double> s = model(Snow{});
    for (int path = 0; path < 20; ++path) {
        const Mat3d F = 0.99 * random.deformation(0.02), step = (1 - 2e-5) * Mat3d::Identity() + 1e-5 * random.matrix();
        Mat3d trial = F, before = return_map(s, trial, 1.02 * s.Jp_min).Fe;
        for (int n = 0; n < 5000; ++n) {
            trial = step * trial;
            const Mat3d Fe = return_map(s, trial, 1.02 * s.Jp_min).Fe;
            REQUIRE((Fe - before).norm() < 2e-4);                   // ‖step − I‖ and what a clamp makes of it
            before = Fe;
        }
        REQUIRE(return_map(s, trial, 1.02 * s.Jp_min).Jp == s.Jp_min);
    }
}

TEST_CASE("snow that begins denser than max_density is not pushed, and is packed no denser", "[snow]") {
    const SnowModel<double> s = model(Snow{}), ice = model(Snow{.rho = 2e4});
    const Mat3d I = Mat3d::Identity();
    CHECK(return_map(s, I, 0.2).Fe == I);
    CHECK(return_map(s, I, 0.2).Jp == 0.2);
    CHECK(return_map(s, Mat3d(0.9 * I), 0.2).Jp == 0.2);
    CHECK((return_map(s, Mat3d(0.9 * I), 0.2).Fe - 0.9 * I).norm() < 1e-15);
    CHECK(return_map(s, Mat3d(1.1 * I), 0.2).Jp == Approx(0.2 * std::pow(1.1 / s.high, 3)));
    CHECK(return_map(ice, Mat3d(0.9 * I), 1.0).Jp == 1);
    CHECK(return_map(ice, Mat3d(0.9 * I), 1.1).Jp == 1);
}

TEST_CASE("a particle of eight returns as it does alone", "[snow]") {
    using P = Pack<double, lanes>;
    RandomInput random;
    const SnowModel<double> s = model(Snow{});
    const SnowModel<P> pack{P(s.mu0), P(s.lambda0), P(s.xi), P(s.low), P(s.high), P(s.Jp_min)};
    for (int n = 0; n < 100; ++n) {
        Mat3<P> trial;
        P Jp;
        for (int l = 0; l < lanes; ++l) {       // elastic, clamped and as dense as can be
            const Mat3d F = (l % 3 == 2 ? 0.9 : 1) * (Mat3d::Identity() + (l % 3 == 0 ? 1e-3 : 0.03) * random.matrix());
            for (int i = 0; i < 9; ++i) trial(i).lanes[l] = F(i);
            Jp.lanes[l] = 1.05 * s.Jp_min;
        }
        const Returned<P> r = return_map(pack, trial, Jp);
        for (int l = 0; l < lanes; ++l) {
            Mat3d F;
            for (int i = 0; i < 9; ++i) F(i) = trial(i)[l];
            const Returned<double> alone = return_map(s, F, Jp[l]);
            REQUIRE(r.Jp[l] == Approx(alone.Jp).epsilon(1e-14));
            for (int i = 0; i < 9; ++i) REQUIRE(r.Fe(i)[l] == Approx(alone.Fe(i)).margin(1e-14));
        }
    }
}

TEST_CASE("snow packed denser than ice hardens no further", "[snow]") {
    const SnowModel<double> ice = model(Snow{}), endless = model(Snow{.max_density = 1e9});
    const double Jp = 400.0 / 917;                                          // as dense as ice
    CHECK(hardened(ice, 0.5).mu == hardened(endless, 0.5).mu);
    CHECK(hardened(ice, 0.2).mu == hardened(ice, Jp).mu);
    CHECK(hardened(ice, Jp).mu == Approx(ice.mu0 * std::exp(10 * (1 - Jp))));
    CHECK(hardened(endless, 0.2).lambda == Approx(endless.lambda0 * std::exp(8.0)));
    CHECK(hardened(model(Snow{.rho = 2e4}), 0.9).mu == model(Snow{}).mu0);  // denser than that from the start
}
