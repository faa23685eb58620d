#pragma once
#include "sim/ledger.h"
#include "sim/settings.h"
#include "sim/snow.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

// The method of Stomakhin et al. 2013 as plainly as it can be written: double precision, one thread, a dense
// grid, every sum over all pairs of particle and node. The ten steps of section 4.1 stand in `step` in their
// order. It shares no formula with sim/: the tests hold the fast program against it, particle by particle.

namespace firn::reference {

struct Particle {
    Vec3d x, v;
    Mat3d F_E = Mat3d::Identity(), F_P = Mat3d::Identity(), C = Mat3d::Zero();
    double m = 0, V0 = 0;
};

struct Node {
    Vec3d x, v_n, v, f;
    double m;
    Mat3d free;             ///< what the solve may change: I, or less where contact fixed something.
    Vec3d J = Vec3d::Zero();    ///< contact's impulse.
    Vec3d v_before = Vec3d::Zero();     ///< v_n as the particles make it; contact changes v_n.
};

struct Svd { Mat3d U, V; Vec3d s; };

/// F = U Σ Vᵀ with rotations U and V; the last singular value carries the sign.
inline Svd svd(const Mat3d& F) {
    const Eigen::JacobiSVD<Mat3d> d(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Svd r{d.matrixU(), d.matrixV(), d.singularValues()};
    if (r.U.determinant() < 0) r.U.col(2) *= -1, r.s(2) *= -1;
    if (r.V.determinant() < 0) r.V.col(2) *= -1, r.s(2) *= -1;
    return r;
}

struct World {
    double h = 0.1, t = 0;
    Vec3d gravity{0, -9.81, 0};
    Snow snow;
    Solver solver;
    std::vector<Collider> colliders;
    std::vector<Particle> particles;
    std::vector<Node> nodes;
    Ledger ledger;          ///< of the last step.

    double N(double d) const {
        d = std::abs(d);
        if (solver.weights == Weights::quadratic)
            return d < 0.5 ? 0.75 - d * d : d < 1.5 ? (1.5 - d) * (1.5 - d) / 2 : 0;
        return d < 1 ? d * d * d / 2 - d * d + 2.0 / 3 : d < 2 ? -d * d * d / 6 + d * d - 2 * d + 4.0 / 3 : 0;
    }
    double dN(double d) const {
        const double a = std::abs(d), sign = d < 0 ? -1 : 1;
        if (solver.weights == Weights::quadratic) return sign * (a < 0.5 ? -2 * a : a < 1.5 ? a - 1.5 : 0);
        return sign * (a < 1 ? 1.5 * a * a - 2 * a : a < 2 ? -a * a / 2 + 2 * a - 2 : 0);
    }
    double w(const Node& i, const Particle& p) const {
        const Vec3d d = (p.x - i.x) / h;
        return N(d.x()) * N(d.y()) * N(d.z());
    }
    Vec3d grad_w(const Node& i, const Particle& p) const {
        const Vec3d d = (p.x - i.x) / h;
        return Vec3d(dN(d.x()) * N(d.y()) * N(d.z()), N(d.x()) * dN(d.y()) * N(d.z()),
                     N(d.x()) * N(d.y()) * dN(d.z())) / h;
    }
    double D() const { return solver.weights == Weights::quadratic ? h * h / 4 : h * h / 3; }

    /// J_P of the densest snow.
    double least_J_P() const { return std::min(1.0, snow.rho / snow.max_density); }
    double hardening(const Particle& p) const {
        return std::exp(snow.xi * (1 - std::max(p.F_P.determinant(), least_J_P())));
    }
    double mu(const Particle& p) const { return snow.E / (2 * (1 + snow.nu)) * hardening(p); }
    double lambda(const Particle& p) const { return snow.E * snow.nu / ((1 + snow.nu) * (1 - 2 * snow.nu)) * hardening(p); }
    /// Σ of the return mapping: Σ̂ clamped to 1 − θ_c … 1 + θ_s. Where that would leave J_P below the least, or below what
    /// it was if that is less, J_P ends there: Σ̂ is clamped to k times that range, det Σ = J_P det Σ̂ / least; k by bisection.
    Vec3d returned(const Vec3d& trial, double J_P) const {
        const auto clamped = [&](double k) {
            return Vec3d(trial.cwiseMax(k * (1 - snow.theta_c)).cwiseMin(k * (1 + snow.theta_s)));
        };
        const double J = J_P * trial.prod() / std::min(J_P, least_J_P());
        if (clamped(1).prod() <= J) return clamped(1);
        double low = 0, high = 1;
        for (int i = 0; i < 100; ++i) {
            const double k = (low + high) / 2;
            (clamped(k).prod() < J ? low : high) = k;
        }
        return clamped(high);
    }
    /// P = 2μ (F − R) + λ (J − 1) J F⁻ᵀ
    Mat3d P(const Particle& p) const {
        const Svd d = svd(p.F_E);
        const double J = p.F_E.determinant();
        return 2 * mu(p) * (p.F_E - d.U * d.V.transpose()) + lambda(p) * (J - 1) * J * p.F_E.inverse().transpose();
    }
    /// ∂²Ψ/∂F² : δF, with δR from Rᵀ δF − δFᵀ R = K S + S K solved for the skew K as nine linear equations, and
    /// δ(J F⁻ᵀ) = (J F⁻ᵀ : δF) F⁻ᵀ − J F⁻ᵀ δFᵀ F⁻ᵀ.
    Mat3d dP(const Particle& p, const Mat3d& dF) const {
        const Svd d = svd(p.F_E);
        const Mat3d R = d.U * d.V.transpose(), S = R.transpose() * p.F_E;
        Eigen::Matrix<double, 9, 3> A;
        for (int k = 0; k < 3; ++k) {
            const Mat3d K = cross(Vec3d::Unit(k)), KS = K * S + S * K;
            A.col(k) = Eigen::Map<const Eigen::Matrix<double, 9, 1>>(KS.data());
        }
        const Mat3d W = R.transpose() * dF - dF.transpose() * R;
        const Vec3d omega = A.colPivHouseholderQr().solve(Eigen::Map<const Eigen::Matrix<double, 9, 1>>(W.data()));
        const double J = p.F_E.determinant();
        const Mat3d T = p.F_E.inverse().transpose(), cof = J * T;
        const double dJ = cof.cwiseProduct(dF).sum();
        return 2 * mu(p) * (dF - R * cross(omega)) + lambda(p) * dJ * cof +
               lambda(p) * (J - 1) * (dJ * T - J * T * dF.transpose() * T);
    }
    static Mat3d cross(const Vec3d& a) {
        Mat3d K;
        K << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
        return K;
    }

    /// Velocity v at x against every body; `free` loses what contact fixes.
    Vec3d against_bodies(const Vec3d& x, Vec3d v, Mat3d& free) const {
        for (const Collider& c : colliders) {
            const Vec3d at = x - t * c.velocity;
            if (signed_distance(c.shape, at) > 0) continue;
            const Vec3d n = outward_normal(c.shape, at), v_rel = v - c.velocity;
            const double v_n = v_rel.dot(n);
            const Vec3d v_t = v_rel - v_n * n;
            if (c.contact != ContactLaw::sticky && v_n >= 0) continue;
            if (c.contact == ContactLaw::sticky || v_t.norm() <= -c.friction * v_n) {
                v = c.velocity;
                free.setZero();
            } else {
                v = v_t + c.friction * v_n * v_t.normalized() + c.velocity;
                const Vec3d m = free * n;
                if (m.norm() > 1e-6) free -= m * m.transpose() / m.squaredNorm();
            }
        }
        return v;
    }

    double flip_share(double dt) const {
        return solver.transfer == Transfer::apic ? 0 : solver.flip_blend.value_or(std::exp(-solver.flip_damping * dt));
    }
    /// The elastic law: node i, v* = v_n + Δt (f/m + g), against every body. FLIP sees v − v_n: of what the node had along n,
    /// nothing; of what the forces give along n, what leads out of the body. PIC's share feels all.
    void bear(Node& i, double dt) const {
        const Vec3d stress = dt * i.f / i.m;
        const bool stressed = stress.norm() > 8 * std::numeric_limits<double>::epsilon() * (i.v.norm() + i.v_n.norm());
        for (const Collider& c : colliders) {
            const Vec3d at = i.x - t * c.velocity, n = outward_normal(c.shape, at);
            if (signed_distance(c.shape, at) > 0) continue;
            if (c.contact == ContactLaw::sticky) {
                i.v = i.v_n = c.velocity, i.free.setZero();
                continue;
            }
            const double in = (i.v - c.velocity).dot(n), load = (i.v - i.v_n).dot(n), had = (i.v_n - c.velocity).dot(n);
            if (in >= 0 && !(stressed && stress.dot(n) < 0)) continue;
            const Vec3d v_t = i.v - c.velocity - in * n;
            i.v_n -= had * n;
            if (load > 0 && had < 0) i.v_n -= std::min(load, -had) * n;
            const double felt = load + (1 - flip_share(dt)) * had;
            if (felt < 0 && v_t.norm() <= -c.friction * felt) {
                i.v = c.velocity, i.free.setZero();
                continue;
            }
            i.v = c.velocity + v_t;
            if (felt < 0) i.v += c.friction * felt * v_t.normalized();
            const Vec3d m = i.free * n;
            if (m.norm() > 1e-6) i.free -= m * m.transpose() / m.squaredNorm();
        }
    }

    void make_nodes() {
        nodes.clear();
        Vec3d low = Vec3d::Constant(1e300), high = -low;
        for (const Particle& p : particles) low = low.cwiseMin(p.x / h), high = high.cwiseMax(p.x / h);
        for (double i = std::floor(low.x()) - 2; i <= high.x() + 2; ++i)
            for (double j = std::floor(low.y()) - 2; j <= high.y() + 2; ++j)
                for (double k = std::floor(low.z()) - 2; k <= high.z() + 2; ++k)
                    nodes.push_back({h * Vec3d(i, j, k), Vec3d::Zero(), Vec3d::Zero(), Vec3d::Zero(), 0, Mat3d::Identity()});
    }
    void rasterize() {
        make_nodes();
        for (Node& i : nodes) {
            for (const Particle& p : particles) {
                const Vec3d v = solver.transfer == Transfer::apic ? Vec3d(p.v + p.C * (i.x - p.x)) : p.v;
                i.m += p.m * w(i, p);
                i.v_n += p.m * w(i, p) * v;
            }
            if (i.m > 0) i.v_n /= i.m;
        }
    }
    void set_volumes() {
        rasterize();
        for (Particle& p : particles) {
            double rho = 0;
            for (const Node& i : nodes) rho += i.m * w(i, p) / (h * h * h);
            p.V0 = p.m / rho / (p.F_E * p.F_P).determinant();
        }
    }

    /// V⁰ δP F_Eᵀ along δF = G F_E; of unstrained snow, Hooke's law, where the solver is conjugate gradients.
    Mat3d A(const Particle& p, const Mat3d& G) const {
        if (solver.linear_solver != LinearSolver::conjugate_gradient) return p.V0 * dP(p, G * p.F_E) * p.F_E.transpose();
        return p.V0 * (mu(p) * (G + G.transpose()) + lambda(p) * G.trace() * Mat3d::Identity());
    }
    /// How implicit a particle is.
    double implicit_weight(const Particle& p, double dt) const {
        if (solver.stiff == Stiff::all) return 1;
        const double x2 = (lambda(p) + 2 * mu(p)) * p.V0 / p.m * dt * dt / (h * h);
        const double explicit_limit = (solver.weights == Weights::quadratic ? 0.45 : 0.6) * std::sqrt(1.5 * (1 - snow.nu) / (1 + snow.nu));
        const double limit = solver.stiff_limit.value_or(explicit_limit);
        return std::max(0.0, 1 - limit * limit / x2);
    }

    /// The bodies at x.
    std::vector<const Collider*> bodies_at(const Vec3d& x) const {
        std::vector<const Collider*> all;
        for (const Collider& c : colliders) if (signed_distance(c.shape, x - t * c.velocity) <= 0) all.push_back(&c);
        return all;
    }
    /// Contact judged by the impulses that hold it over the whole step: a body that would pull lets go, what sticks with more
    /// than friction can give slides, friction is of the load. `start`: before the solve, with the impulses that it began with.
    bool judge_again(std::vector<Node>& start, double dt) const {
        bool changed = false;
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const Node& i = nodes[k];
            const std::vector<const Collider*> bodies = bodies_at(i.x);
            const auto sticky = [](const Collider* c) { return c->contact == ContactLaw::sticky; };
            const auto moves = [&](const Particle& p) { return w(i, p) != 0 && implicit_weight(p, dt) > 0; };
            if (i.free == Mat3d::Identity() || std::any_of(bodies.begin(), bodies.end(), sticky)) continue;
            if (std::none_of(particles.begin(), particles.end(), moves)) continue;      // the solve did not change it
            const Vec3d felt = i.J + i.m * flip_share(dt) * (i.v_before - i.v_n);
            Vec3d J = Vec3d::Zero();
            if (std::all_of(bodies.begin(), bodies.end(), [&](const Collider* c) {
                    const Vec3d n = outward_normal(c->shape, i.x - t * c->velocity);
                    return i.J.dot(n) < 0 && felt.dot(n) < 0; })) {
                start[k].free.setIdentity(), start[k].v_n = i.v_before;
            } else {
                if (bodies.size() != 1) continue;
                const Vec3d n = outward_normal(bodies[0]->shape, i.x - t * bodies[0]->velocity), J_t = i.J - i.J.dot(n) * n;
                const double bound = bodies[0]->friction * std::max(0.0, felt.dot(n));
                if (J_t.norm() == 0 || (i.free == Mat3d::Zero() && J_t.norm() <= bound)) continue;
                J = start[k].J.dot(n) * n + bound * J_t.normalized();
                start[k].free = Mat3d::Identity() - n * n.transpose();
            }
            start[k].v += (J - start[k].J) / i.m, start[k].J = J;
            changed = true;
        }
        return changed;
    }
    /// Step 6, and again where contact changes.
    void solve(double dt) {
        std::vector<Node> start = nodes;
        solve_held(dt);
        if (!judge_again(start, dt)) return;
        nodes = start;
        solve_held(dt);
    }

    /// (M + β Δt² H) vⁿ⁺¹ = M v* with H = Σ w ∂²Φ/∂x² as a dense matrix, solved for what contact left free.
    void solve_held(double dt) {
        std::vector<Node*> active;
        for (Node& i : nodes) if (i.m > 0) active.push_back(&i);
        const auto n = static_cast<Eigen::Index>(3 * active.size());
        Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n), Q = H;
        Eigen::VectorXd v(n), m(n);
        for (std::size_t a = 0; a < active.size(); ++a) {
            v.segment<3>(3 * a) = active[a]->v;
            m.segment<3>(3 * a).setConstant(active[a]->m);
            Q.block<3, 3>(3 * a, 3 * a) = active[a]->free;
        }
        for (const Particle& p : particles)
            for (std::size_t b = 0; b < active.size(); ++b) {
                if (w(*active[b], p) == 0) continue;
                for (int c = 0; c < 3; ++c) {
                    const Mat3d A_p = implicit_weight(p, dt) * A(p, Vec3d::Unit(c) * grad_w(*active[b], p).transpose());
                    for (std::size_t a = 0; a < active.size(); ++a)
                        H.block<3, 1>(3 * a, 3 * b + c) += dt * dt * A_p * grad_w(*active[a], p);
                }
            }
        const Eigen::MatrixXd matrix = Eigen::MatrixXd(m.asDiagonal()) + solver.beta * H;
        // Scaled by M^−½ from both sides, since masses span many powers of ten.
        const Eigen::VectorXd scale = m.cwiseSqrt().cwiseInverse();
        const Eigen::MatrixXd E = scale.asDiagonal() * (Q * matrix * Q) * scale.asDiagonal();
        const Eigen::VectorXd residual = scale.cwiseProduct(Q * (H * (-solver.beta * v)));
        const Eigen::MatrixXd fixed = Eigen::MatrixXd::Identity(n, n) - Q;
        const Eigen::VectorXd dv = scale.cwiseProduct((E + fixed).partialPivLu().solve(residual));
        for (std::size_t a = 0; a < active.size(); ++a) active[a]->v += active[a]->free * dv.segment<3>(3 * a);
        for (std::size_t a = 0; a < active.size(); ++a) v.segment<3>(3 * a) = active[a]->v;
        const Eigen::VectorXd internal = -solver.beta * (H * v);    // M (vⁿ⁺¹ − v*) is this and what holds it
        for (std::size_t a = 0; a < active.size(); ++a) {
            const Vec3d held = active[a]->m * active[a]->free * dv.segment<3>(3 * a) - internal.segment<3>(3 * a);
            active[a]->J += held - active[a]->free * held;
        }
    }

    double kinetic() const {
        double sum = 0;
        for (const Particle& p : particles) sum += p.m / 2 * p.v.squaredNorm();
        return sum;
    }
    double psi(const Particle& p, const Mat3d& F_E) const {
        const Svd d = svd(F_E);
        const double J = F_E.determinant();
        return mu(p) * (F_E - d.U * d.V.transpose()).squaredNorm() + lambda(p) / 2 * (J - 1) * (J - 1);
    }
    /// What the nodes' part of a step does to the ledger: each impulse with the mean of vⁿ and vⁿ⁺¹.
    void account(double dt, double kinetic_before) {
        double before = 0, after = 0;
        const double alpha = flip_share(dt);
        for (const Node& i : nodes) {       // particles feel v − v_n, and the share 1 − α of v
            const Vec3d unfelt = alpha * (i.v_before - i.v_n), v = i.v + unfelt, twice_mean = i.v_before + v;
            before += i.m / 2 * i.v_before.squaredNorm(), after += i.m / 2 * v.squaredNorm();
            ledger.gravity += i.m * dt * gravity.dot(twice_mean) / 2, ledger.contact += (i.J + i.m * unfelt).dot(twice_mean) / 2;
        }
        ledger.to_grid = before - kinetic_before, ledger.integration = after - before - ledger.gravity - ledger.contact;
        ledger.to_particles = -after;
    }

    void step(double dt) {
        ledger = {};
        const double kinetic_before = kinetic();
        rasterize();                                                                        //  1 (2: set_volumes)
        for (Node& i : nodes)                                                               //  3
            for (const Particle& p : particles) i.f -= p.V0 * P(p) * p.F_E.transpose() * grad_w(i, p);
        for (Node& i : nodes) if (i.m > 0) i.v = i.v_n + dt * (i.f / i.m + gravity);        //  4
        const bool elastic = solver.node_contact == NodeContact::elastic && solver.transfer == Transfer::flip;
        for (Node& i : nodes) {                                                             //  5
            if (!(i.m > 0)) continue;
            const Vec3d v_star = i.v;
            i.v_before = i.v_n;
            if (elastic) bear(i, dt);
            else i.v = against_bodies(i.x, i.v, i.free);
            i.J = i.m * (i.v - v_star);
        }
        if (solver.integrator == Integrator::semi_implicit) solve(dt);                      //  6
        account(dt, kinetic_before);
        for (Particle& p : particles) {
            Mat3d grad_v = Mat3d::Zero(), C = Mat3d::Zero();
            Vec3d pic = Vec3d::Zero(), flip = p.v;
            for (const Node& i : nodes) {
                grad_v += i.v * grad_w(i, p).transpose();
                C += w(i, p) * i.v * (i.x - p.x).transpose() / D();
                pic += w(i, p) * i.v;
                flip += w(i, p) * (i.v - i.v_n);
            }
            const Mat3d F_trial = (Mat3d::Identity() + dt * grad_v) * p.F_E;                //  7
            const Mat3d F = F_trial * p.F_P;
            ledger.integration += p.V0 * (psi(p, F_trial) - psi(p, p.F_E)), ledger.plastic -= p.V0 * psi(p, F_trial);
            const Svd d = svd(F_trial);
            const Vec3d s = returned(d.s, p.F_P.determinant());
            p.F_E = d.U * s.asDiagonal() * d.V.transpose();
            p.F_P = d.V * s.cwiseInverse().asDiagonal() * d.U.transpose() * F;
            const double alpha = flip_share(dt);
            p.v = (1 - alpha) * pic + alpha * flip;                                         //  8
            p.C = C;
            ledger.plastic += p.V0 * psi(p, p.F_E);
            ledger.to_particles += p.m / 2 * p.v.squaredNorm(), ledger.contact -= p.m / 2 * p.v.squaredNorm();
            Mat3d ignored = Mat3d::Identity();
            p.v = against_bodies(p.x, p.v, ignored);                                        //  9
            ledger.contact += p.m / 2 * p.v.squaredNorm();
            p.x += dt * p.v;                                                                // 10
        }
        t += dt;
    }
};

}  // namespace firn::reference
