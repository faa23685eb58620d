#pragma once
#include "sim/account.h"
#include "sim/rest.h"
#include "sim/step.h"
#include "sim/strain_rates.h"

namespace firn {

/// Energies between the steps [J], for the ledger.
struct Between {
    double trial = 0;       ///< Σ V⁰ Ψ of F̂_E, before the return mapping.
    double kinetic = 0;     ///< Σ ½ m v² after step 8, before the bodies.
    void include(const Between& b) { trial += b.trial, kinetic += b.kinetic; }
};

/// Extremes of one block while it is gathered, eight particles at a time: squares, and sums in double.
template <class Real> struct ExtremesOfLanes {
    using P = Pack<Real, lanes>;
    P speed2{0}, wave2{0}, rate2{0};
    Pack<double, lanes> kinetic{0}, elastic{0}, height{0}, trial{0}, free{0};

    Extremes reduced() const {
        Extremes e;
        for (int l = 0; l < lanes; ++l)
            e.include({double(speed2[l]), double(wave2[l]), double(rate2[l]), 0, kinetic[l], elastic[l], height[l]});
        e.speed = std::sqrt(e.speed), e.wave = std::sqrt(e.wave), e.strain_rate = std::sqrt(e.strain_rate);
        return e;
    }
    Between between() const {
        Between b;
        for (int l = 0; l < lanes; ++l) b.trial += trial[l], b.kinetic += free[l];
        return b;
    }
};

/// What steps 7 to 10 need besides particles and nodes.
template <class Real> struct Motion {
    Real dt, flip_blend;
    Vec3<Real> gravity;
    const std::vector<SnowModel<Real>>& materials;
    const std::vector<Collider>& colliders;
    double t;                       ///< [s]
    double rest_speed, rest_time;   ///< of Solver [m/s], [s].
    double mass;                    ///< of all particles [kg].
};

/// A particle that is nowhere any more.
struct Lost { std::uint32_t id; Vec3d x; };

/// What they leave behind.
template <class Real> struct Advanced {
    Extremes extremes;
    Between between;
    double slept = 0;                                       ///< kinetic energy lost by what fell asleep [J].
    std::vector<Exchange> exchanges;                        ///< of each body with the particles.
    std::vector<std::vector<Departure<Real>>> departures;   ///< of each block.
    std::vector<Lost> lost;
};

/// Step 9 for eight particles at xⁿ with the masses m, `count` of which there are.
template <class Real>
void collide_particles(const Vec3<Pack<Real, lanes>>& x, Vec3<Pack<Real, lanes>>& v, const Pack<Real, lanes>& m, int count,
                       const Motion<Real>& motion, std::vector<Exchange>& exchanges) {
    exchanges.resize(motion.colliders.size());
    for (int l = 0; l < count; ++l) {
        const Vec3d at(x(0)[l], x(1)[l], x(2)[l]), before(v(0)[l], v(1)[l], v(2)[l]);
        const Collided c = collide(at, before, motion.colliders, motion.t);
        if (!c.touched) continue;
        share_out(at, double(m[l]) * (c.v - before), motion.colliders, motion.t, exchanges);
        for (int a = 0; a < 3; ++a) v(a).lanes[l] = Real(c.v(a));
    }
}

/// Steps 7 to 10 in one pass over the particles, after `finish_nodes`:
///   7  ∇v_p = Σ_i v_iⁿ⁺¹ ∇w_ipᵀ,  F̂_E = (I + Δt ∇v_p) F_E,  return mapping
///   8  v_p ← (1−α) Σ_i v_iⁿ⁺¹ w_ip + α (v_p + Σ_i (v_iⁿ⁺¹ − v_iⁿ) w_ip)
///      APIC: v_p = Σ_i v_iⁿ⁺¹ w_ip,  C_p = Σ_i w_ip v_iⁿ⁺¹ (x_i − x_p)ᵀ / D
///   9  v_p against the bodies, at x_pⁿ
///  10  x_p ← x_p + Δt v_p
template <Weights kind, Transfer transfer, class Real>
Advanced<Real> advance(Particles<Real>& ps, Grid<Real>& grid, const Motion<Real>& motion) {
    using P = Pack<Real, lanes>;
    const Real h = grid.h;
    std::vector<ParticleBlock>& blocks = grid.blocks.particle_blocks;
    std::vector<Extremes> extremes(blocks.size());
    std::vector<Between> between(blocks.size());
    std::vector<std::vector<Exchange>> exchanges(blocks.size());
    Advanced<Real> all;
    std::vector<StrainRates> rates(omp_get_max_threads());
    all.departures.resize(blocks.size());
    const auto all_blocks = static_cast<std::ptrdiff_t>(blocks.size());
#pragma omp parallel for schedule(static)
    for (std::ptrdiff_t n = 0; n < all_blocks; ++n)
        if (blocks[n].asleep()) {
            extremes[n] = advance_lump(ps.lumps[blocks[n].lump], motion.dt);
            between[n] = {extremes[n].elastic, extremes[n].kinetic};
        }
    gather_blocks<BSpline<kind>::width>(grid.blocks, grid.nodes, [&](std::size_t n, const auto& tile) {
        ParticleBlock& b = blocks[n];
        const Vec3<Real> origin = (block_width * b.coordinates).cast<Real>();
        const Vec3d center = double(h) * (block_width * b.coordinates.cast<double>() + Vec3d::Constant(BSpline<kind>::center));
        const bool contact = near(motion.colliders, center, std::sqrt(3.0) * block_width / 2 * (1 + 1e-5) * h, motion.t);
        ExtremesOfLanes<Real> sum;
        StrainRates& own_rates = rates[omp_get_thread_num()];
        b.bases = 0;
        std::vector<std::uint32_t> leaving;
        for (std::size_t k = 0; k < b.groups.size(); ++k) {
            const std::uint32_t g = b.groups[k], next = b.groups[std::min(k + 1, b.groups.size() - 1)];
            ps.for_each_field([next](const auto& field) { field.prefetch(next); });
            const int count = b.count_in(k);
            const Vec3<P> x = vectors_of(ps.x, g);
            Reach<Real, kind, transfer> reach(x, b, h);
            reach.sum_up_z();
            const Seen<Real> seen = look(tile, reach, count);

            const Mat3<P> Fe = matrices_of(ps.Fe, g), F_trial = Fe + P(motion.dt) * seen.gradient * Fe;
            const SnowModel<P> snow = models_of(ps, motion.materials, g);
            const Returned<P> r = return_map(snow, F_trial, ps.Jp.pack(g));
            store(ps.Fe, g, r.Fe), store(ps.tau, g, r.tau);
            ps.Jp.pack(g) = r.Jp;

            Vec3<P> v = seen.high;
            if constexpr (transfer == Transfer::apic) {
                const auto slow = v.squaredNorm() < P(Real(motion.rest_speed * motion.rest_speed));
                const P scale = select(slow, P(0), P(Real(1 / (BSpline<kind>::second_moment * double(h)))));
                store(ps.C, g, Mat3<P>(seen.moment * scale));
            } else {
                v += (motion.rest_speed > 0 ? seen.share : P(motion.flip_blend)) * vectors_of(ps.v, g);
            }
            const P m = ps.m.pack(g), V0 = ps.V0.pack(g);
            sum.free += doubles(P(m * v.squaredNorm() / P(2)));
            if (contact) collide_particles(x, v, m, count, motion, exchanges[n]);
            const Vec3<P> x_new = x + P(motion.dt) * v;
            store(ps.v, g, v), store(ps.x, g, x_new);

            const P speed2 = v.squaredNorm();
            sum.speed2 = maximum(sum.speed2, speed2);
            sum.wave2 = maximum(sum.wave2, select(m > P(0), P((r.k.lambda + P(2) * r.k.mu) * V0 / m), P(0)));
            const P rate2 = seen.gradient.squaredNorm();
            sum.rate2 = maximum(sum.rate2, rate2);
            const P bearing = m * minimum(P(1), P(r.k.mu / snow.mu0));      // snow that came apart bears nothing
            for (int l = 0; l < count; ++l) own_rates.add(float(rate2[l]), StrainRates::units(bearing[l] / motion.mass));
            sum.kinetic += doubles(P(m * speed2 / P(2)));
            sum.elastic += doubles(P(V0 * r.energy_density)), sum.trial += doubles(P(V0 * r.trial_density));
            sum.height += doubles(P(m * (P(motion.gravity(0)) * x_new(0) + P(motion.gravity(1)) * x_new(1) +
                                         P(motion.gravity(2)) * x_new(2))));

            // Who is still here?
            const Vec3<P> base = Place<kind, P>(x_new, P(h)).base;
            Vec3<P> local;
            for (int a = 0; a < 3; ++a) local(a) = base(a) - P(origin(a));
            const auto in = [](const P& a) { return (a > P(-1)) & (a < P(Real(block_width))); };
            const auto stays = in(local(0)) & in(local(1)) & in(local(2));
            const auto bits = integers(select(stays, P((local(0) * P(16) + local(1) * P(4)) + local(2)), P(0)));
            for (int l = 0; l < count; ++l) {
                if (stays[l]) { b.bases |= NodeSet(1) << bits[l]; continue; }
                const Vec3<Real> at(base(0)[l], base(1)[l], base(2)[l]);
                if (lost(at)) {
#pragma omp critical
                    all.lost.push_back({ps.id[std::size_t(lanes) * g + l], Vec3d(x_new(0)[l], x_new(1)[l], x_new(2)[l])});
                    continue;
                }
                const auto [block, bit] = block_of(at);
                leaving.push_back(std::uint32_t(lanes * k + l));
                all.departures[n].push_back({block, bit, {}});
            }
        }
        for (std::size_t i = leaving.size(); i-- > 0;) all.departures[n][i].particle = take_out(ps, b, leaving[i]);
        extremes[n] = sum.reduced(), between[n] = sum.between();
        b.quiet = extremes[n].speed < motion.rest_speed ? b.quiet + motion.dt : 0;
    });
    for (std::size_t n = 0, free = 0; n < blocks.size(); ++n)
        if (blocks[n].quiet > motion.rest_time && all.departures[n].empty() && !blocks[n].asleep() &&
            !near_moving(motion.colliders, blocks[n], h, motion.t)) {
            const double lost = fall_asleep(ps, blocks[n], extremes[n], free);
            all.slept += lost, extremes[n].kinetic -= lost;
        }
    for (const Extremes& e : extremes) all.extremes.include(e);
    for (const Between& b : between) all.between.include(b);
    all.exchanges.resize(motion.colliders.size());
    for (const auto& of_block : exchanges)
        for (std::size_t c = 0; c < of_block.size(); ++c) all.exchanges[c] += of_block[c];
    for (std::size_t i = 1; i < rates.size(); ++i) rates[0].add(rates[i]);
    all.extremes.bulk_rate = std::sqrt(rates[0].above_all_but(1e-3));
    return all;
}

}  // namespace firn
