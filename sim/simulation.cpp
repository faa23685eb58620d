#include "sim/simulation.h"

#include "sim/method.h"

namespace firn {
namespace {

/// Calls f with the weights and the transfer as types.
template <class Real, class F> auto choose(const Solver& s, F&& f) {
    const bool flip = s.transfer == Transfer::flip;
    if (s.weights == Weights::cubic)
        return flip ? f.template operator()<Method<Real, Weights::cubic, Transfer::flip>>()
                    : f.template operator()<Method<Real, Weights::cubic, Transfer::apic>>();
    return flip ? f.template operator()<Method<Real, Weights::quadratic, Transfer::flip>>()
                : f.template operator()<Method<Real, Weights::quadratic, Transfer::apic>>();
}

}  // namespace

std::unique_ptr<Simulation> make_simulation(const Setup& setup, ParticleSet&& start) {
    const auto make = [&]<class M>() -> std::unique_ptr<Simulation> { return std::make_unique<M>(setup, std::move(start)); };
    return setup.solver.precision == Precision::single ? choose<float>(setup.solver, make)
                                                       : choose<double>(setup.solver, make);
}

std::size_t bytes_per_particle(const Solver& s) {
    const std::size_t real = s.precision == Precision::single ? 4 : 8;
    std::size_t numbers = 3 + 3 + 9 + 1 + 6 + 1 + 1;                       // x v Fe Jp tau m V0
    if (s.transfer == Transfer::apic) numbers += 9;                        // C
    if (s.integrator != Integrator::explicit_euler) numbers += 3 + 1 + 9 + 2;   // an element's t, at, F_E, k
    if (s.integrator == Integrator::semi_implicit) numbers += 15;          // KirchhoffDifferential
    if (s.integrator == Integrator::newton) numbers += 33;                 // ProjectedDifferential
    if (s.rest_speed > 0) numbers += 5;                                    // a lump's nodes
    return numbers * real * 26 / 25 + 1 + 4;                               // groups that are not full; material, id
}

std::size_t bytes_per_node(const Solver& s) {
    const std::size_t real = s.precision == Precision::single ? 4 : 8;
    // A node is linked to from up to 343/64 blocks under cubic weights, 216/64 under quadratic ones.
    const std::size_t links = sizeof(Link) * (s.weights == Weights::cubic ? 6 : 4);
    const std::size_t fields = s.integrator == Integrator::explicit_euler ? 0 : s.integrator == Integrator::newton ? 13 : 9;
    return real * (8 + 4 * fields + (fields > 0 ? 2 : 0)) + links;      // node, fields of the solve, m and D
}

std::size_t count_nodes(const ParticleSet& particles, double h, Weights weights) {
    const auto count = [&]<Weights kind>() {
        Blocks blocks;
        blocks.link(arrange<kind, double>(particles.size(), h, [&](std::size_t p) {
            return Vec3d(particles.x[p].cwiseMax(-1e9 * h).cwiseMin(1e9 * h)); }).blocks, BSpline<kind>::width);
        return blocks.nodes;
    };
    return weights == Weights::cubic ? count.template operator()<Weights::cubic>() : count.template operator()<Weights::quadratic>();
}

double estimate_steps(const Setup& setup, const ParticleSet& particles, double seconds) {
    const Solver& s = setup.solver;
    if (s.dt) return std::ceil(seconds / *s.dt);
    double speed = 0;
    for (const Vec3d& v : particles.v) speed = std::max(speed, v.norm());
    // What falls for all that time, at most half a second.
    speed = std::max(speed, std::sqrt(speed * speed + std::pow(setup.gravity.norm() * std::min(seconds, 0.5), 2)));
    double dt = std::min(s.max_dt, 0.6 * setup.h / std::max(speed, 1e-30));
    constexpr double cells = 5;  // over which what hits a body is strained: as measured in the shipped scenes
    if (!setup.colliders.empty()) dt = std::min(dt, cells * s.strain_limit * setup.h / std::max(speed, 1e-30));
    if (s.integrator == Integrator::explicit_euler) {
        constexpr double packs_to = 0.8;  // of its J_P, where it lands
        double wave2 = 0, courant = std::numeric_limits<double>::max();
        for (std::size_t p = 0; p < particles.size(); ++p) {
            const Snow& snow = setup.materials[particles.material[p]];
            const SnowModel<double> m = model(snow);
            const Lame<double> k = hardened(m, packs_to * particles.Jp[p]);
            wave2 = std::max(wave2, (k.lambda + 2 * k.mu) / snow.rho);
            courant = std::min(courant, stiff_limit(s, snow));
        }
        const double share = s.initial_volume == InitialVolume::grid ? 2 : 1;  // V⁰ ρ₀/m where snow ends
        dt = std::min(dt, courant * setup.h / std::sqrt(share * wave2));
    }
    return std::ceil(seconds / dt);
}

}  // namespace firn
