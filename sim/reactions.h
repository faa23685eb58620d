#pragma once
#include "sim/elements.h"
#include "sim/friction.h"
#include "sim/implicit.h"

namespace firn {

/// The nodes of a Newton step that lie in bodies, and what contact makes of them.
template <class Real> class Reactions {
public:
    /// The nodes of the grid hold (v*, m | vⁿ, 0).
    template <Weights kind>
    Reactions(const Elements<Real, kind>& elements, const Grid<Real>& grid, const Bodies& bodies) : bodies_(bodies) {
        for (const GridBlock& b : grid.blocks.grid_blocks) {
            std::uint32_t n = b.first;
            for (NodeSet left = b.nodes; left != 0; left &= left - 1, ++n) {
                const std::uint32_t i = elements.number_of(n);
                if (i == no_slot || !(grid.nodes[n][3] > 0)) continue;
                const Vec3d x = grid.position(b, std::countr_zero(left));
                if (!near(bodies.colliders, x, 0, bodies.t)) continue;
                const Node<Real>& v = grid.nodes[n];
                inside_.push_back({n, i, x, Vec3d(v[4], v[5], v[6]), Vec3d(v[0], v[1], v[2]), double(v[3])});
            }
        }
    }

    bool empty() const { return inside_.empty(); }
    const std::vector<FixedNode<Real>>& fixed() const { return fixed_; }        ///< by their new numbers.
    std::vector<Friction<Real>>& frictions() { return frictions_; }
    std::vector<std::size_t> rough() const {                                    ///< nodes with friction.
        std::vector<std::size_t> nodes;
        for (const Friction<Real>& c : frictions_) nodes.push_back(c.node);
        return nodes;
    }

    /// Contact of v*: D = m.
    void judge_start(NodeField<Real>& v) {
        clear();
        for (const Inside& n : inside_) judge_node(n, n.v_star, n.v_star - n.v_n, n.m, v);
    }
    /// Contact of v − r/D, r = M (v − v̂) − Δt f. v keeps what is free of it.
    void judge_reactions(const Pages<Real>& D, const NodeField<Real>& v_hat, const NodeField<Real>& f, double dt, NodeField<Real>& v) {
        clear();
        for (const Inside& n : inside_)
            judge_node(n, at(v, n.i) - reaction(n, v_hat, f, dt, v) / double(D[n.i]), given(n, v_hat, f, dt), D[n.i], v);
    }

    /// The nodes that contact touched, with its impulses; FLIP's vⁿ there goes to the grid.
    void finish(const NodeField<Real>& v_hat, const NodeField<Real>& f, double dt, const NodeField<Real>& v, Grid<Real>& grid,
                std::vector<FixedNode<Real>>& fixed) const {
        auto c = fixed_.begin();
        for (const Inside& n : inside_) {
            if (c == fixed_.end() || c->node != n.i) continue;
            const Vec3d J = reaction(n, v_hat, f, dt, v);
            fixed.push_back({n.node, c->free, n.v_n.template cast<Real>(), J.template cast<Real>(), n.x});
            if (bodies_.law == NodeContact::elastic) {
                const Vec3d before = before_contact(n.x, n.v_n, given(n, v_hat, f, dt), c->free.template cast<double>(), bodies_.colliders, bodies_.t);
                for (int a = 0; a < 3; ++a) grid.nodes[n.node].lanes[4 + a] = Real(before(a));
            }
            ++c;
        }
    }

private:
    struct Inside { std::size_t node; std::uint32_t i; Vec3d x, v_n, v_star; double m; };   ///< numbers in the grid and anew.

    static Vec3d at(const NodeField<Real>& u, std::size_t i) { return {u.at[i][0], u.at[i][1], u.at[i][2]}; }
    /// r [kg m/s]
    static Vec3d reaction(const Inside& n, const NodeField<Real>& v_hat, const NodeField<Real>& f, double dt, const NodeField<Real>& v) {
        return n.m * (at(v, n.i) - at(v_hat, n.i)) - dt * at(f, n.i);
    }
    /// Δt (f/m + g) [m/s]
    static Vec3d given(const Inside& n, const NodeField<Real>& v_hat, const NodeField<Real>& f, double dt) {
        return at(v_hat, n.i) - n.v_n + dt / n.m * at(f, n.i);
    }
    void clear() { fixed_.clear(), frictions_.clear(); }
    void judge_node(const Inside& n, const Vec3d& trial, const Vec3d& d, double D, NodeField<Real>& v) {
        const double share = bodies_.law == NodeContact::elastic ? bodies_.flip_blend * n.m / D : 0;
        const Judged c = judge(n.x, {trial, n.v_n, d, share}, bodies_.colliders, bodies_.t);
        if (!c.touched) return;
        const Vec3d now = at(v, n.i), kept = c.v + c.free * (now - c.v);
        v.at[n.i] = NodeVector<Real>::of(Real(kept(0)), Real(kept(1)), Real(kept(2)), 0);
        const Mat3<Real> free = c.free.template cast<Real>();
        fixed_.push_back({.node = n.i, .free = free});
        const double bound = D * (c.free * (c.v - trial)).norm();
        if (bound > 0) frictions_.push_back({n.i, free, (c.body + now - trial).template cast<Real>(), Real(bound), Real(D)});
    }

    Bodies bodies_;
    std::vector<Inside> inside_;
    std::vector<FixedNode<Real>> fixed_;
    std::vector<Friction<Real>> frictions_;
};

}  // namespace firn
