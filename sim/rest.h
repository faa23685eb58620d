#pragma once
#include "sim/collision.h"
#include "sim/node_field.h"
#include "sim/particles.h"

namespace firn {

// Snow at rest. A block whose particles have all been slower than `rest_speed` for `rest_time` falls asleep: they stop
// where they are, strained as they are, and the block goes on as one lump of mass M and velocity u. It gives the nodes
// what its particles gave them, (m_i u, m_i | f_i), and has its share of what the nodes do,
//
//     u ← Σ_i m_i/M (v_iⁿ⁺¹ + α_i (u − v_iⁿ)),
//
// which is step 8 summed over its particles: mass and momentum stay what they are. Before anything is deformed by that, it
// wakes, and its particles go on with u, as soon as
// - a node that it reaches would move faster than `rest_speed` (nodes with a small mass m_i from it count with v_i² m_i/m̄,
//   where m̄ is the mean: they are flung about, and move little);
// - the nodes push it by more than `rest_speed` in `rest_time`;
// - u would have carried it farther than `rest_speed` does in `rest_time`;
// - a moving body comes near, or a particle comes in.
// What is neglected are ways and strains of what moves slower. `rest_time` is at least twice what gravity takes to make snow
// as fast as `rest_speed`, so that nothing sleeps that falls. Snow would ring for long before it sleeps: nodes slower than
// `rest_speed` have the FLIP share α_i = 0, which damps it, and as long as all that is at a node uses the same one, conserves
// momentum; under APIC particles as slow lose their C, and with it the angular momentum in it.

/// α_i of a node with vⁿ⁺¹.
template <class Real>
Real flip_share(const Node<Real>& v, Real flip_blend, Real rest_speed) {
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < rest_speed * rest_speed ? Real(0) : flip_blend;
}

/// Whether a body that moves comes near a block.
inline bool near_moving(const std::vector<Collider>& colliders, const ParticleBlock& b, double h, double t) {
    const Vec3d center = h * (block_width * b.coordinates.cast<double>() + Vec3d::Constant(3));
    return std::any_of(colliders.begin(), colliders.end(), [&](const Collider& c) {
        return c.velocity != Vec3d::Zero() && signed_distance(c, center, t) <= 4 * std::sqrt(3.0) * h;
    });
}

/// Puts a block to sleep of which `e` are the extremes; not while others fall asleep. All lumps before number `free` are taken.
/// Returns the kinetic energy that is lost [J].
template <class Real>
double fall_asleep(Particles<Real>& ps, ParticleBlock& b, const Extremes& e, std::size_t& free) {
    while (free < ps.lumps.size() && ps.lumps[free].mass > 0) ++free;
    if (free == ps.lumps.size()) ps.lumps.emplace_back();
    b.lump = static_cast<std::int32_t>(free);
    Lump<Real>& lump = ps.lumps[free];
    for (std::uint32_t n = 0; n < b.count; ++n) {
        const std::size_t slot = b.slot(n);
        const double m = ps.m.at(slot);
        const Vec3d v = vector_of(ps.v, slot).template cast<double>();
        lump.mass += m, lump.velocity += m * v;
        for (int a = 0; a < 3; ++a) ps.v.at(slot, a) = 0;
        for (int k = 0; k < 9 && ps.affine; ++k) ps.C.at(slot, k) = 0;
    }
    lump.velocity /= lump.mass;
    lump.extremes = {0, e.wave, 0, 0, 0, e.elastic, e.height};
    return e.kinetic - lump.mass * lump.velocity.squaredNorm() / 2;
}

template <class Real>
void wake(Particles<Real>& ps, ParticleBlock& b) {
    for (std::uint32_t n = 0; n < b.count; ++n)
        for (int a = 0; a < 3; ++a) ps.v.at(b.slot(n), a) = Real(ps.lumps[b.lump].velocity(a));
    ps.lumps[b.lump] = {};
    b.lump = -1;
    b.quiet = 0;
}

/// Keeps what the particles of a block that has fallen asleep, and stopped, add to its nodes.
template <class Real, int stencil_width>
void remember(Tile<Node<Real>, stencil_width>& tile, const Blocks& blocks, const ParticleBlock& b,
              Lump<Real>& lump) {
    lump.nodes.reserve(b.last_link - b.first_link);
    tile.for_each(blocks, b, [&](const Node<Real>& n, std::uint32_t) { lump.nodes.push_back(n); });
}

/// Steps 1 and 3 of a block asleep.
template <class Real>
void add_lump(const Lump<Real>& lump, const ParticleBlock& b, Grid<Real>& grid) {
    const Vec3<Real> u = lump.velocity.template cast<Real>();
    const Node<Real> velocity = Node<Real>::of(u(0), u(1), u(2), 0, 0, 0, 0, 0);
    for (std::size_t l = 0; l < lump.nodes.size(); ++l) {
        const Node<Real>& n = lump.nodes[l];
        grid.nodes[grid.blocks.links[b.first_link + l].node] += n + Node<Real>(n[3]) * velocity;
    }
}

/// What the nodes, (vⁿ⁺¹, m | vⁿ, 0), do to what is asleep: finds its next velocity, or wakes it for one of the reasons above.
/// `dt`, `t` [s]. Returns whether any woke.
template <class Real>
bool move_lumps(Particles<Real>& ps, Grid<Real>& grid, const Solver& solver, Real flip_blend,
                const std::vector<Collider>& colliders, double t, double dt) {
    const Real fastest = Real(solver.rest_speed), push = Real(solver.rest_speed * dt / solver.rest_time);
    const auto count = static_cast<std::ptrdiff_t>(grid.blocks.particle_blocks.size());
    int woken = 0;
#pragma omp parallel for schedule(static) reduction(+ : woken)
    for (std::ptrdiff_t i = 0; i < count; ++i) {
        ParticleBlock& b = grid.blocks.particle_blocks[i];
        if (!b.asleep()) continue;
        Lump<Real>& lump = ps.lumps[b.lump];
        const Real mean = Real(lump.mass / double(lump.nodes.size()));  // mass at a node
        const Vec3<Real> u = lump.velocity.template cast<Real>();
        Node<Real> most(0), sum(0);  // of v², of m v
        Vec3<Real> kept(0, 0, 0);    // Σ_i m_i α_i (u − v_iⁿ)
        for (std::size_t l = 0; l < lump.nodes.size(); ++l) {
            const Node<Real>& v = grid.nodes[grid.blocks.links[b.first_link + l].node];
            const Real m = lump.nodes[l][3];
            most = maximum(most, Node<Real>(Node<Real>(std::min(m / mean, Real(1))) * (v * v)));
            sum += Node<Real>(m) * v;
            if (const Real share = flip_share(v, flip_blend, fastest); share > 0)
                kept += m * share * (u - Vec3<Real>(v[4], v[5], v[6]));
        }
        sum /= Node<Real>(Real(lump.mass));
        const Vec3<Real> v(sum[0], sum[1], sum[2]), change = v - Vec3<Real>(sum[4], sum[5], sum[6]);
        const bool rests = most[0] + most[1] + most[2] <= fastest * fastest &&
                           change.squaredNorm() <= push * push &&
                           lump.way <= solver.rest_speed * solver.rest_time;
        if (rests && !near_moving(colliders, b, grid.h, t))
            lump.next_velocity = (v + kept / Real(lump.mass)).template cast<double>();
        else
            wake(ps, b), ++woken;
    }
    return woken > 0;
}

/// Step 8 of a block asleep.
template <class Real>
Extremes advance_lump(Lump<Real>& lump, double dt) {
    lump.velocity = lump.next_velocity;
    lump.way += lump.velocity.norm() * dt;
    Extremes e = lump.extremes;
    e.speed = lump.velocity.norm(), e.kinetic += lump.mass * lump.velocity.squaredNorm() / 2;
    return e;
}

/// f_i of all that is asleep [N].
template <class Real>
NodeField<Real> forces_at_rest(const Particles<Real>& ps, const Grid<Real>& grid) {
    NodeField<Real> f(grid.size());
    for (const ParticleBlock& b : grid.blocks.particle_blocks) {
        if (!b.asleep()) continue;
        const std::vector<Node<Real>>& nodes = ps.lumps[b.lump].nodes;
        for (std::size_t l = 0; l < nodes.size(); ++l)
            f.at[grid.blocks.links[b.first_link + l].node] +=
                NodeVector<Real>::of(nodes[l][4], nodes[l][5], nodes[l][6], 0);
    }
    return f;
}

}  // namespace firn
