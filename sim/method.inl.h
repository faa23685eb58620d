#pragma once
#include "sim/method.h"

#include <fmt/format.h>

#include <istream>
#include <ostream>

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

namespace firn {

/// Counts numbers below the smallest normal one (1.2e-38 for float) as zero, in every thread. The weights of a
/// particle far out in its stencil are such numbers where snow has come apart, they matter to nothing, and each
/// operation on one takes an x86 processor about 150 cycles.
inline void flush_denormals() {
#ifdef __SSE2__
#pragma omp parallel
    _mm_setcsr(_mm_getcsr() | 0x8040);  // flush to zero, denormals are zero
#endif
}

template <class Real, Weights kind, Transfer transfer>
Method<Real, kind, transfer>::Method(const Setup& setup, ParticleSet&& start) : setup_(setup), n_(start.size()) {
    for (const Snow& s : setup_.materials) {
        const SnowModel<double> m = model(s);
        materials_.push_back({Real(m.mu0), Real(m.lambda0), Real(m.xi), Real(m.low), Real(m.high), Real(m.Jp_min)});
    }
    check_start(start);
    Solver& solver = setup_.solver;
    if (const double g = setup_.gravity.norm(); g > 0) solver.rest_time = std::max(solver.rest_time, 2 * solver.rest_speed / g);
    grid_.h = Real(setup_.h);
    Arrangement arrangement = arrange<kind, Real>(n_, grid_.h, [&](std::size_t p) { return start.x[p].template cast<Real>(); });
    const std::vector<std::uint32_t>& slots = arrangement.slots;
    ps_.affine = transfer == Transfer::apic, ps_.several_materials = setup_.materials.size() > 1;
    ps_.resize(arrangement.groups);
    const auto take = [&](auto& values, auto&& put) {               // and give their memory back
        for (std::size_t p = 0; p < n_; ++p) put(slots[p], values[p]);
        std::decay_t<decltype(values)>().swap(values);
    };
    for (std::size_t p = 0; p < n_; ++p) {
        ps_.id[slots[p]] = static_cast<std::uint32_t>(p);
        const bool sampled = setup_.solver.initial_volume == InitialVolume::sampled;
        const double V0 = start.V0[p] > 0 ? start.V0[p] : sampled ? start.m[p] / setup_.materials[start.material[p]].rho : 0;
        ps_.V0.at(slots[p]) = Real(V0);
        if (ps_.several_materials) ps_.material[slots[p]] = start.material[p];
        extremes_.speed = std::max(extremes_.speed, start.v[p].norm());
    }
    take(start.Fe, [&](std::size_t slot, const Mat3d& F) { for (int k = 0; k < 9; ++k) ps_.Fe.at(slot, k) = Real(F(k)); });
    take(start.x, [&](std::size_t slot, const Vec3d& x) { for (int a = 0; a < 3; ++a) ps_.x.at(slot, a) = Real(x(a)); });
    take(start.v, [&](std::size_t slot, const Vec3d& v) { for (int a = 0; a < 3; ++a) ps_.v.at(slot, a) = Real(v(a)); });
    take(start.m, [&](std::size_t slot, double m) { ps_.m.at(slot) = Real(m); });
    take(start.Jp, [&](std::size_t slot, double Jp) { ps_.Jp.at(slot) = Real(Jp); });
    start = {};
    grid_.blocks.link(std::move(arrangement.blocks), BSpline<kind>::width);
    for (std::size_t g = 0; g < ps_.groups; ++g)
        store(ps_.tau, g, kirchhoff_stress(left_strain(matrices_of(ps_.Fe, g)),
                                           hardened(models_of(ps_, materials_, g), ps_.Jp.pack(g))));
    rasterize_with_forces<kind, transfer>(ps_, grid_);
    set_volumes<kind>(ps_, grid_);                                  //  2  ρ_p = Σ_i m_i w_ip / h³,  V_p⁰ = m_p / ρ_p
    grid_.blocks.for_each_particle([&](std::size_t slot) {
        const Lame<Real> k = hardened(materials_[ps_.material_of(slot)], ps_.Jp.at(slot));
        const double modulus = k.lambda + 2 * k.mu;
        extremes_.wave = std::max(extremes_.wave, std::sqrt(modulus * ps_.V0.at(slot) / ps_.m.at(slot)));
        stiffness_ += modulus * ps_.V0.at(slot);
    });
    const Totals sum = totals();
    extremes_.kinetic = sum.kinetic, extremes_.elastic = sum.elastic, extremes_.height = -sum.potential;
    mass_ = sum.mass, resting_ = sum.mass * solver.rest_speed * solver.rest_speed / 2;
    energy_.start = extremes_.energy(), energy_.lowest = energy_.highest = extremes_.height;
}

/// A particle cannot begin inside out, or as nothing: no motion leads there, and J_P could not follow.
template <class Real, Weights kind, Transfer transfer>
void Method<Real, kind, transfer>::check_start(const ParticleSet& start) const {
    for (std::size_t p = 0; p < n_; ++p) {
        const auto must = [&](bool good, const char* name, Real value, const char* allowed) {
            if (!good) fail(fmt::format("particle {} has {} = {:g}, which must be {}", p, name, value, allowed));
        };
        const Real J = determinant(Mat3<Real>(start.Fe[p].template cast<Real>()));
        const Real v = Vec3<Real>(start.v[p].template cast<Real>()).norm(), Jp = Real(start.Jp[p]), m = Real(start.m[p]);
        must(J > 0 && std::isfinite(J), "det F_E", J, "above 0 and finite");
        must(std::isfinite(v), "|v|", v, "finite");
        must(Jp > 0 && std::isfinite(Jp), "J_P", Jp, "above 0 and finite");
        must(m > 0 && std::isfinite(m), "mass", m, "above 0 and finite");
        const Vec3<Real> x = start.x[p].template cast<Real>();
        if (lost(Place<kind, Real>(x, Real(setup_.h)).base)) fail_lost({{static_cast<std::uint32_t>(p), start.x[p]}});
    }
}

/// Energy cannot come from nowhere: an unstable step shows in it long before anything overflows. Moving bodies
/// give what they like, and are not checked; round-off in F_E is worth some 10⁻⁹ of the stiffness, and lumps asleep do not
/// lose height as they gain speed.
template <class Real, Weights kind, Transfer transfer> void Method<Real, kind, transfer>::check_energy() {
    if (!std::isfinite(extremes_.energy() + extremes_.height + extremes_.wave))
        fail("speeds or stresses are not finite any more");
    energy_.lowest = std::min(energy_.lowest, extremes_.height), energy_.highest = std::max(energy_.highest, extremes_.height);
    const double given = energy_.start + energy_.highest - energy_.lowest;
    const bool pushed = std::any_of(setup_.colliders.begin(), setup_.colliders.end(),
                                    [](const Collider& c) { return c.velocity != Vec3d::Zero(); });
    if (!pushed && extremes_.energy() > 2 * given + 1e-9 * stiffness_ + resting_)
        fail(fmt::format("the snow has {:g} J of which the start and gravity gave {:g} J: the steps are unstable; where "
                         "forces are explicit, about {:g} s is the longest that is not", extremes_.energy(), given,
                         courant() * setup_.h / extremes_.wave));
}

/// The ledger of a step that took the particles from `extremes_` to `a`.
template <class Real, Weights kind, Transfer transfer>
void Method<Real, kind, transfer>::balance_energy(const NodeAccount& nodes, const Advanced<Real>& a, StepReport& report) const {
    Ledger& l = report.ledger;
    l.gravity = nodes.gravity;
    l.to_grid = nodes.before - extremes_.kinetic;
    l.integration = nodes.after - nodes.before - nodes.gravity - nodes.contact + a.between.trial - extremes_.elastic;
    l.plastic = a.extremes.elastic - a.between.trial;
    l.to_particles = a.between.kinetic - nodes.after;
    l.contact = nodes.contact + (a.extremes.kinetic + a.slept - a.between.kinetic);
    l.sleep = -a.slept;
    for (std::size_t c = 0; c < setup_.colliders.size(); ++c) {
        report.exchanges[c] += a.exchanges[c];
        report.exchanges[c].velocity = setup_.colliders[c].velocity;
    }
}

/// Δt of the next step [s]. Chosen: at most max_dt; no particle crosses more than 0.6 of a cell; ‖Δt ∇v‖ ≤ strain_limit but
/// for a thousandth of the mass, which may strain by ½: one crumb shall not set everybody's step; and where forces are
/// explicit, Δt ≤ x_s h/c with the hardened speed of sound c (`stable_courant`).
template <class Real, Weights kind, Transfer transfer> double Method<Real, kind, transfer>::wanted_dt() const {
    const Solver& solver = setup_.solver;
    if (solver.dt) return *solver.dt;
    double dt = solver.max_dt;
    if (extremes_.speed > 0) dt = std::min(dt, 0.6 * setup_.h / extremes_.speed);
    if (extremes_.strain_rate > 0) dt = std::min(dt, 0.5 / extremes_.strain_rate);
    if (extremes_.bulk_rate > 0) dt = std::min(dt, solver.strain_limit / extremes_.bulk_rate);     // of turns, too
    if (solver.integrator == Integrator::explicit_euler && extremes_.wave > 0)
        dt = std::min(dt, courant() * setup_.h / extremes_.wave);
    return dt;
}

/// The least x_s of the materials.
template <class Real, Weights kind, Transfer transfer> double Method<Real, kind, transfer>::courant() const {
    double x = std::numeric_limits<double>::max();
    for (const Snow& snow : setup_.materials) x = std::min(x, stiff_limit(setup_.solver, snow));
    return x;
}

template <class Real, Weights kind, Transfer transfer>
StepReport Method<Real, kind, transfer>::step(double remaining) {
    constexpr int most_rejections = 20;
    flush_denormals();
    StepReport report;
    const double wanted = wanted_dt();
    if (!(wanted > 1e-12 * remaining)) fail(fmt::format("the longest stable step would be {:g} s", wanted));
    double dt = wanted;
    if (setup_.solver.dt) {
        if (wanted >= remaining * (1 - 1e-9)) dt = remaining;
    } else {
        dt = remaining / std::ceil(remaining / wanted - 1e-9);      // equal steps up to the frame
    }
    while (!take_step(dt, report)) {
        const Offender& worst = *std::min_element(offenders_.begin(), offenders_.end(),
            [](const Offender& a, const Offender& b) { return a.id < b.id; });
        if (++report.rejected > most_rejections)
            fail(fmt::format("particle {} could be turned inside out (‖Δt ∇v‖ = {:g}) even by a step of {:g} s",
                             worst.id, worst.value, dt));
        dt /= 2;
    }
    check_energy();
    report.dt = dt;
    report.nodes = grid_.size();
    for (const ParticleBlock& b : grid_.blocks.particle_blocks) report.asleep += b.asleep() ? b.count : 0;
    t_ += dt;
    ++steps_;
    return report;
}

template <class Real, Weights kind, Transfer transfer>
void Method<Real, kind, transfer>::fail(const std::string& what) const {
    throw SimulationError(fmt::format(
        "step {} at t = {:.6g} s: {}; a smaller solver.dt or max_dt, softer materials (E, xi) or slower "
        "bodies may help, and solver.precision: double where lengths or speeds are extreme", steps_ + 1, t_, what));
}

template <class Real, Weights kind, Transfer transfer>
void Method<Real, kind, transfer>::fail_lost(const std::vector<Lost>& lost) const {
    const Lost& first = *std::min_element(lost.begin(), lost.end(), [](const Lost& a, const Lost& b) { return a.id < b.id; });
    fail(fmt::format("particle {} is at ({:g}, {:g}, {:g}) m, where {} numbers cannot tell places in a cell apart", first.id,
                     first.x(0), first.x(1), first.x(2), sizeof(Real) == 4 ? "float" : "double"));
}

template <class Real, Weights kind, Transfer transfer> Totals Method<Real, kind, transfer>::totals() const {
    constexpr double D = BSpline<kind>::second_moment;
    Totals sum;
    const auto add = [&](std::size_t slot, const Vec3d& v) {
        const double m = ps_.m.at(slot);
        const Vec3d x = vector_of(ps_.x, slot).template cast<double>();
        const SnowModel<double> s = model(setup_.materials[ps_.material_of(slot)]);
        const Lame<double> k = hardened(s, double(ps_.Jp.at(slot)));
        sum.mass += m;
        sum.momentum += m * v;
        sum.angular_momentum += m * x.cross(v);
        if (transfer == Transfer::apic) {                           // Σ_i w (x_i − x_p) × C (x_i − x_p) = D h² Σ_a e_a × C e_a
            const Mat3d C = matrix_of(ps_.C, slot).template cast<double>();
            sum.angular_momentum += m * D * setup_.h * setup_.h *
                                    Vec3d(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
        }
        sum.kinetic += m * v.squaredNorm() / 2;
        const Mat3d Fe = matrix_of(ps_.Fe, slot).template cast<double>();
        sum.elastic += ps_.V0.at(slot) * energy_density(left_strain(Fe), k);
        sum.potential -= m * setup_.gravity.dot(x);
        sum.max_density = std::max(sum.max_density, m / (double(ps_.V0.at(slot)) * Fe.determinant() * double(ps_.Jp.at(slot))));
    };
    for (const ParticleBlock& b : grid_.blocks.particle_blocks)
        for (std::uint32_t n = 0; n < b.count; ++n)
            add(b.slot(n), b.asleep() ? ps_.lumps[b.lump].velocity : Vec3d(vector_of(ps_.v, b.slot(n)).template cast<double>()));
    return sum;
}

/// Where particle `id` is now, for every id.
template <class Real, Weights kind, Transfer transfer>
std::vector<std::size_t> Method<Real, kind, transfer>::places() const {
    std::vector<std::size_t> at(n_);
    grid_.blocks.for_each_particle([&](std::size_t slot) { at[ps_.id[slot]] = slot; });
    return at;
}

template <class Real, Weights kind, Transfer transfer>
template <int C>
std::vector<float> Method<Real, kind, transfer>::in_order(const Field<Real, C>& field) const {
    std::vector<float> values(C * n_);
    grid_.blocks.for_each_particle([&](std::size_t slot) {
        for (int a = 0; a < C; ++a) values[C * ps_.id[slot] + a] = static_cast<float>(field.at(slot, a));
    });
    return values;
}

template <class Real, Weights kind, Transfer transfer>
ParticleRows Method<Real, kind, transfer>::rows(bool full) const {
    ParticleRows rows{sizeof(Real) == 8, {"x", "y", "z", "vx", "vy", "vz"}, n_, {}};
    if (full) {
        for (const char* name : {"mass", "volume", "Jp"}) rows.columns.emplace_back(name);
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) rows.columns.push_back(fmt::format("Fe_{}{}", r, c));
        if (setup_.solver.rest_speed > 0) rows.columns.emplace_back("asleep");
    }
    std::vector<bool> asleep(full && setup_.solver.rest_speed > 0 ? lanes * ps_.groups : 0);
    for (const ParticleBlock& b : grid_.blocks.particle_blocks)
        for (std::uint32_t n = 0; n < b.count && !asleep.empty(); ++n) asleep[b.slot(n)] = b.asleep();
    std::vector<Real> values;
    values.reserve(n_ * rows.columns.size());
    for (const std::size_t p : places()) {
        for (int a = 0; a < 3; ++a) values.push_back(ps_.x.at(p, a));
        for (int a = 0; a < 3; ++a) values.push_back(ps_.v.at(p, a));
        if (!full) continue;
        values.insert(values.end(), {ps_.m.at(p), ps_.V0.at(p), ps_.Jp.at(p)});
        for (int k = 0; k < 9; ++k) values.push_back(ps_.Fe.at(p, 3 * (k % 3) + k / 3));
        if (!asleep.empty()) values.push_back(asleep[p] ? Real(1) : Real(0));
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(values.data());
    rows.data.assign(bytes, bytes + values.size() * sizeof(Real));
    return rows;
}

template <class T> void write_raw(std::ostream& out, const T* data, std::size_t count) {
    out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(count * sizeof(T)));
}
template <class T> void read_raw(std::istream& in, T* data, std::size_t count) {
    if (!in.read(reinterpret_cast<char*>(data), static_cast<std::streamsize>(count * sizeof(T))))
        throw std::runtime_error("the state ends too early");
}

/// What a saved state must agree in with the simulation that restores it.
template <class Real, Weights kind, Transfer transfer> std::array<std::uint64_t, 4> signature(std::size_t n) {
    return {n, sizeof(Real), std::uint64_t(kind), std::uint64_t(transfer)};
}

/// The numbers that every block of particles is saved with.
struct BlockHeader { Vec3i coordinates; std::uint32_t count; NodeSet bases; double quiet; std::uint64_t asleep; };

/// Block after block, so that sums over particles have the same order afterwards wherever the groups are.
template <class Real, Weights kind, Transfer transfer>
void Method<Real, kind, transfer>::save(std::ostream& out) const {
    const auto own = signature<Real, kind, transfer>(n_);
    write_raw(out, own.data(), own.size());
    write_raw(out, &extremes_, 1), write_raw(out, &energy_, 1), write_raw(out, &t_, 1), write_raw(out, &steps_, 1);
    for (const ParticleBlock& b : grid_.blocks.particle_blocks) {
        const BlockHeader header{b.coordinates, b.count, b.bases, b.quiet, b.asleep() ? 1u : 0u};
        write_raw(out, &header, 1);
        if (b.asleep()) {
            const Lump<Real>& lump = ps_.lumps[b.lump];
            write_raw(out, &lump.mass, 1), write_raw(out, &lump.velocity, 1), write_raw(out, &lump.way, 1), write_raw(out, &lump.extremes, 1);
        }
        for (const std::uint32_t g : b.groups) {
            ps_.for_each_field([&](const auto& field) { write_raw(out, &field.group(g), 1); });
            write_raw(out, &ps_.id[lanes * g], lanes);
            if (ps_.several_materials) write_raw(out, &ps_.material[lanes * g], lanes);
        }
    }
}

template <class Real, Weights kind, Transfer transfer>
void Method<Real, kind, transfer>::restore(std::istream& in) {
    auto saved = signature<Real, kind, transfer>(0);
    read_raw(in, saved.data(), saved.size());
    if (saved != signature<Real, kind, transfer>(n_)) throw std::runtime_error("the state is of another simulation");
    read_raw(in, &extremes_, 1), read_raw(in, &energy_, 1), read_raw(in, &t_, 1), read_raw(in, &steps_, 1);
    Particles<Real> restored;
    restored.affine = ps_.affine, restored.several_materials = ps_.several_materials;
    std::vector<ParticleBlock> blocks;
    for (std::size_t n = 0; n < n_; n += blocks.back().count) {
        BlockHeader header{};
        read_raw(in, &header, 1);
        if (header.count == 0 || header.count > n_ - n) throw std::runtime_error("the state has a block of no sense");
        blocks.push_back({.coordinates = header.coordinates, .count = header.count, .bases = header.bases, .quiet = header.quiet});
        if (header.asleep != 0) {
            blocks.back().lump = static_cast<std::int32_t>(restored.lumps.size());
            Lump<Real>& lump = restored.lumps.emplace_back();
            read_raw(in, &lump.mass, 1), read_raw(in, &lump.velocity, 1), read_raw(in, &lump.way, 1), read_raw(in, &lump.extremes, 1);
        }
        for (std::uint32_t done = 0; done < header.count; done += lanes) {
            const std::uint32_t g = restored.new_group();
            blocks.back().groups.push_back(g);
            restored.for_each_field([&](auto& field) { read_raw(in, &field.group(g), 1); });
            read_raw(in, &restored.id[lanes * g], lanes);
            if (restored.several_materials) read_raw(in, &restored.material[lanes * g], lanes);
        }
    }
    ps_ = std::move(restored);
    grid_.blocks.link(std::move(blocks), BSpline<kind>::width);
    grid_.blocks.for_each_particle([&](std::size_t slot) {
        if (ps_.id[slot] >= n_) throw std::runtime_error("the state names a particle that there is not");
    });
}

}  // namespace firn
