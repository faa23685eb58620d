#pragma once
#include "sim/hessian.h"
#include "sim/implicit.h"
#include "sim/linear_system.h"

#include <limits>

namespace firn {

// With x₀ = vⁿ, but v* in what contact fixed, and u = vⁿ⁺¹ − x₀ the equation of solve_implicit reads
//
//   (M + β Δt² H) u = M (v* − x₀) − β Δt² H x₀.
//
// v* itself, the explicit step's end, would be a start that is far off wherever that step is unstable.

/// Contact of v* judged by the impulses J that hold it over the whole step: of contact, and what the solve's equation lacks at
/// a node. Where J pulls, the body lets go of the node; where it sticks with more than friction can give, it slides; and where
/// it slides, friction is of the load that it bears. The residual r gets what contact gives more or less than before.
template <class Real, Weights kind> class Rejudgement {
public:
    Rejudgement(const Elements<Real, kind>& elements, Grid<Real>& grid, const Bodies& bodies) : elements_(elements), grid_(grid), bodies_(bodies) {}

    /// Whether anything changed.
    bool operator()(std::vector<FixedNode<Real>>& fixed, NodeField<Real>& r) const {
        bool changed = false;
        for (FixedNode<Real>& f : fixed) {
            const std::uint32_t i = elements_.number_of(f.node);
            if (i == no_slot || f.free.isIdentity()) continue;
            Node<Real>& n = grid_.nodes[f.node];
            const Vec3<Real> r_i(r.at[i][0], r.at[i][1], r.at[i][2]), before(n[4], n[5], n[6]);
            const Vec3d J = (f.impulse - (r_i - f.free * r_i)).template cast<double>();
            const Vec3d felt = J + double(n[3]) * bodies_.flip_blend * (f.v_n - before).template cast<double>();   // by FLIP
            const Vec3<Real> impulse = f.impulse;
            if (pulls(f.x, J) && pulls(f.x, felt)) {
                f.free.setIdentity(), f.impulse.setZero();
                for (int a = 0; a < 3; ++a) n.lanes[4 + a] = f.v_n(a);
            } else if (!slide(f, J, felt)) {
                continue;
            }
            const Vec3<Real> more = f.impulse - impulse;
            r.at[i] += NodeVector<Real>::of(more(0), more(1), more(2), 0);
            changed = true;
        }
        return changed;
    }

private:
    bool at(const Collider& c, const Vec3d& x) const { return signed_distance(c, x, bodies_.t) <= 0; }
    /// Whether an impulse would pull snow at x to each body there, and none is sticky.
    bool pulls(const Vec3d& x, const Vec3d& J) const {
        return std::none_of(bodies_.colliders.begin(), bodies_.colliders.end(), [&](const Collider& c) {
            return at(c, x) && (c.contact == ContactLaw::sticky || J.dot(outward_normal(c, x, bodies_.t)) >= 0);
        });
    }
    /// Friction where one body alone is. Whether it changed.
    bool slide(FixedNode<Real>& f, const Vec3d& J, const Vec3d& felt) const {
        const Collider* body = nullptr;
        for (const Collider& c : bodies_.colliders) {
            if (!at(c, f.x)) continue;
            if (body != nullptr || c.contact == ContactLaw::sticky) return false;
            body = &c;
        }
        if (body == nullptr) return false;
        const Vec3d n = outward_normal(*body, f.x, bodies_.t), J_t = J - J.dot(n) * n;
        const double bound = body->friction * std::max(0.0, felt.dot(n)), length = J_t.norm();
        const bool sticks = f.free.isZero();
        if (!(length > 0) || (sticks && length <= bound)) return false;
        const Vec3d normal = double(f.impulse.template cast<double>().dot(n)) * n;
        f.impulse = (normal + bound / length * J_t).template cast<Real>();
        f.free = (Mat3d::Identity() - n * n.transpose()).template cast<Real>();
        return true;
    }

    const Elements<Real, kind>& elements_;
    Grid<Real>& grid_;
    const Bodies& bodies_;
};

template <Weights kind, class Real>
Convergence solve_implicit(const Particles<Real>& ps, Grid<Real>& grid, const std::vector<SnowModel<Real>>& materials,
                           const StiffnessLimits& limits, std::vector<FixedNode<Real>>& fixed, const Bodies& bodies, double dt, const Solver& solver) {
    using N4 = NodeVector<Real>;
    const Elements<Real, kind> elements(ps, grid, materials, limits);
    if (elements.size() == 0) return {};
    const bool hooke = solver.linear_solver == LinearSolver::conjugate_gradient;
    System<Real, kind> system(elements, grid, fixed, solver.beta * dt * dt, hooke);
    const Rejudgement<Real, kind> rejudge(elements, grid, bodies);
    const Pages<Real>& m = system.masses();
    const std::vector<std::uint32_t>& nodes = elements.grid_nodes();

    NodeField<Real> v_star(nodes.size()), x0(nodes.size()), b(nodes.size()), u(nodes.size());
    x0.for_each([&](std::ptrdiff_t i) {
        const Node<Real>& n = grid.nodes[nodes[i]];
        v_star.at[i] = N4::of(n[0], n[1], n[2], 0), x0.at[i] = N4::of(n[4], n[5], n[6], 0);
    });
    for (const FixedNode<Real>& f : system.fixed()) {       // vⁿ + (I − P)(v* − vⁿ)
        const N4 change = v_star.at[f.node] - x0.at[f.node];
        const Vec3<Real> d(change[0], change[1], change[2]), held = d - f.free * d;
        x0.at[f.node] += N4::of(held(0), held(1), held(2), 0);
    }
    const double factor = solver.beta * dt * dt;
    const auto go = [&](const auto& hessian) {
        hessian(x0, b);
        b.for_each([&](std::ptrdiff_t i) { b.at[i] = N4(m[i]) * (v_star.at[i] - x0.at[i]) - N4(Real(factor)) * b.at[i]; });
        const double floor = 4 * std::numeric_limits<Real>::epsilon() * std::sqrt(system.dot(v_star, v_star));
        const double first = system.norm(b);
        Convergence all;
        for (bool last = system.fixed().empty(), done = false; !done && all.converged; last = true) {
            const double before = system.norm(b), tolerance = (last ? 1 : 10) * solver.tolerance;
            const Convergence c = system.solve(u, b, hessian, solver.linear_solver, 0, std::max(floor, tolerance * first), solver.max_iterations);
            all.iterations += c.iterations, all.converged = c.converged;
            for (const float left : c.history) all.history.push_back(float(before / first * left));
            if (!last && rejudge(fixed, b)) system.hold(among(elements, fixed));
            done = last;
        }
        return all;
    };
    Convergence c = hooke ? go(LinearElasticHessian<Real, kind>(elements)) : go(Hessian<Real, kind>(elements, ps));
    u.for_each([&](std::ptrdiff_t i) {
        for (int a = 0; a < 3; ++a) grid.nodes[nodes[i]].lanes[a] = x0.at[i][a] + u.at[i][a];
    });
    for (FixedNode<Real>& f : fixed) {
        const std::uint32_t i = elements.number_of(f.node);
        if (i == no_slot) continue;
        const Vec3<Real> r(b.at[i][0], b.at[i][1], b.at[i][2]);
        f.impulse -= r - f.free * r;
    }
    c.unknowns = nodes.size();
    return c;
}

}  // namespace firn
