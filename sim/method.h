#pragma once
#include "sim/advance.h"
#include "sim/simulation.h"

#include <chrono>

namespace firn {

/// Tells how much time went by since the last lap, or since it was made.
class Stopwatch {
public:
    void lap(double& seconds) {
        const auto now = std::chrono::steady_clock::now();
        seconds += std::chrono::duration<double>(now - last_).count(), last_ = now;
    }

private:
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The method for one choice of precision, weights and transfer.
template <class Real, Weights kind, Transfer transfer> class Method final : public Simulation {
public:
    Method(const Setup&, ParticleSet&&);

    StepReport step(double remaining) override;
    std::size_t size() const override { return n_; }
    double time() const override { return t_; }
    long steps() const override { return steps_; }
    Totals totals() const override;
    std::vector<float> positions() const override { return in_order(ps_.x); }
    std::vector<float> velocities() const override { return in_order(ps_.v); }
    std::vector<float> volumes() const override { return in_order(ps_.V0); }
    ParticleRows rows(bool full) const override;
    void save(std::ostream&) const override;
    void restore(std::istream&) override;

private:
    bool take_step(double dt, StepReport&);
    double wanted_dt() const;
    double courant() const;
    std::vector<std::size_t> places() const;
    template <int C> std::vector<float> in_order(const Field<Real, C>&) const;
    void check_start(const ParticleSet&) const;
    void check_energy();
    void balance_energy(const NodeAccount&, const Advanced<Real>&, StepReport&) const;
    [[noreturn]] void fail(const std::string& what) const;
    [[noreturn]] void fail_lost(const std::vector<Lost>&) const;

    Setup setup_;
    std::vector<SnowModel<Real>> materials_;
    std::size_t n_ = 0;
    Particles<Real> ps_;
    Grid<Real> grid_;
    std::vector<Offender> offenders_;       ///< of the last attempt.
    Extremes extremes_;                     ///< after the last step.
    struct { double start, lowest, highest; } energy_;  ///< Σ ½ m v² + V⁰ Ψ at the start; range of Σ m g·x [J].
    double mass_ = 0;                       ///< of all particles [kg].
    double resting_ = 0;                    ///< ½ m v² of all at `rest_speed` [J].
    double stiffness_ = 0;                  ///< Σ (λ + 2μ) V⁰ at the start [J].
    double t_ = 0;                          ///< [s]
    long steps_ = 0;
};

/// One step of the paper, section 4.1; the numbers are the paper's. False: vⁿ⁺¹ could turn particles inside out
/// (`offenders_`), and nothing has changed for them.
template <class Real, Weights kind, Transfer transfer>
bool Method<Real, kind, transfer>::take_step(double dt, StepReport& report) {
    const Solver& solver = setup_.solver;
    const Vec3<Real> g = setup_.gravity.cast<Real>();
    const Real flip_blend = transfer == Transfer::apic ? Real(0) : Real(solver.flip_blend.value_or(std::exp(-dt * solver.flip_damping)));
    const Motion<Real> motion{Real(dt), flip_blend, g, materials_, setup_.colliders, t_,
                              solver.rest_speed, solver.rest_time, mass_};
    const Vec3d fall = dt * setup_.gravity;
    const NodeContact contact = transfer == Transfer::apic ? NodeContact::inelastic : solver.node_contact;  // APIC has no vⁿ

    const Bodies bodies{setup_.colliders, t_, contact, flip_blend};
    const StiffnessLimits limits(solver, setup_.materials, setup_.h, dt);
    Stopwatch watch;

    rasterize_with_forces<kind, transfer>(ps_, grid_);              //  1  m_i = Σ_p m_p w_ip,  (m v)_i = Σ_p m_p v_p w_ip
                                                                    //  2  V_p⁰, once: in the constructor
    watch.lap(report.seconds.scatter);                              //  3  f_i = −Σ_p V_p⁰ P F_Eᵀ ∇w_ip
    accelerate(grid_, Real(dt), g);                                 //  4  v* = v + Δt (f / m + g)
    auto fixed = collide_nodes(grid_, setup_.colliders, t_, contact, flip_blend, fall);  //  5  v* against the bodies
    watch.lap(report.seconds.grid);
    if (solver.integrator == Integrator::semi_implicit)             //  6  (M + β Δt² ∂²Φ/∂x²) vⁿ⁺¹ = M v*
        report.add(solve_implicit<kind>(ps_, grid_, materials_, limits, fixed, bodies, dt, solver));
    if (solver.integrator == Integrator::newton) {                  //     or the minimum of ½‖v − v̂‖² + Φ(x + Δt v),
        report.add(solve_newton<kind>(ps_, grid_, materials_, limits, fixed, bodies, fall, dt, solver));
        add_impulses(fixed, collide_nodes(grid_, setup_.colliders, t_, contact, flip_blend));   //     with its own step 5
    }
    watch.lap(report.seconds.solve);
    if (move_lumps(ps_, grid_, solver, flip_blend, setup_.colliders, t_, dt) && solver.integrator != Integrator::explicit_euler)
        return take_step(dt, report);                               //     the solve wants the stiffness of what woke
    offenders_ = inverted<kind>(ps_, grid_, Real(dt));
    if (!offenders_.empty()) return false;                          //     a step too long is not taken
    report.exchanges.assign(setup_.colliders.size(), {});
    const NodeAccount nodes = account(grid_, fixed, dt, setup_.gravity, flip_blend, Real(solver.rest_speed), setup_.colliders, t_, report.exchanges);
    finish_nodes(grid_, flip_blend, Real(solver.rest_speed));
    watch.lap(report.seconds.grid);
    Advanced<Real> a = advance<kind, transfer>(ps_, grid_, motion);       //  7  F_E, J_P;  8  v_p;  9  v_p against the bodies;
    watch.lap(report.seconds.gather);                               // 10  x_p ← x_p + Δt v_p
    if (!a.lost.empty()) fail_lost(a.lost);
    balance_energy(nodes, a, report);
    extremes_ = a.extremes;
    migrate(ps_, grid_.blocks, a.departures, BSpline<kind>::width); //     blocks and nodes under the particles, for
    watch.lap(report.seconds.sort);                                 //     the next step
    return true;
}

extern template class Method<float, Weights::cubic, Transfer::flip>;
extern template class Method<float, Weights::cubic, Transfer::apic>;
extern template class Method<float, Weights::quadratic, Transfer::flip>;
extern template class Method<float, Weights::quadratic, Transfer::apic>;
extern template class Method<double, Weights::cubic, Transfer::flip>;
extern template class Method<double, Weights::cubic, Transfer::apic>;
extern template class Method<double, Weights::quadratic, Transfer::flip>;
extern template class Method<double, Weights::quadratic, Transfer::apic>;

}  // namespace firn
