#include "app/interrupt.h"
#include "app/study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <unordered_map>

namespace firn {

// x y z of every particle, in the order of sampling.
static std::vector<Vec3d> positions(const Simulation& simulation) {
    const ParticleRows rows = simulation.rows(false);
    std::vector<Vec3d> x(rows.count);
    const std::size_t row = rows.columns.size() * (rows.twofold ? 8 : 4);
    for (std::size_t p = 0; p < rows.count; ++p) {
        const std::byte* const at = rows.data.data() + p * row;
        float f[3];
        if (rows.twofold) std::memcpy(x[p].data(), at, sizeof(double) * 3);
        else std::memcpy(f, at, sizeof f), x[p] = Vec3d(f[0], f[1], f[2]);
    }
    return x;
}

constexpr int steps_between_sums = 8;   // a sum of energies costs about a step

// Follows the sum of all energies.
class EnergyBalance {
public:
    /// `gain` [J]: kinetic energy of what falls freely for the whole time.
    EnergyBalance(const Totals& t, double gain)
        : first_(sum(t)), lowest_(first_), now_(first_), scale_(moving(t)), expected_(moving(t) + gain) {}

    void add(const Totals& t) {
        now_ = sum(t);
        made_ = std::max(made_, now_ - lowest_), lowest_ = std::min(lowest_, now_);
        scale_ = std::max(scale_, moving(t));
    }
    bool bounded(double blow_up) const { return std::isfinite(now_) && now_ - first_ <= blow_up * expected_; }
    void store(Trial& t) const { t.energy = now_ - first_, t.energy_made = made_, t.energy_scale = scale_; }

private:
    static double moving(const Totals& t) { return t.kinetic + t.elastic; }
    static double sum(const Totals& t) { return moving(t) + t.potential; }
    double first_, lowest_, now_, scale_, expected_, made_ = 0;
};

// Runs to the next frame; false where something ended the trial.
static bool take_frame(Trial& trial, Simulation& simulation, EnergyBalance& balance, const Span& span) {
    using Clock = std::chrono::steady_clock;
    for (double remaining = 1 / span.fps; remaining > 0;) {
        if (interrupted()) return trial.failure = "interrupted", false;
        const auto begun = Clock::now();
        const std::clock_t cpu_begun = std::clock();
        const StepReport report = simulation.step(remaining);
        trial.seconds += std::chrono::duration<double>(Clock::now() - begun).count();
        trial.cpu_seconds += double(std::clock() - cpu_begun) / CLOCKS_PER_SEC;
        trial.simulated += report.dt;
        ++trial.steps, trial.iterations += report.iterations, trial.rejected += report.rejected;
        trial.unconverged += !report.converged;
        remaining = report.dt >= remaining ? 0 : remaining - report.dt;
        if (remaining > 0 && trial.steps % steps_between_sums != 0) continue;
        balance.add(simulation.totals());
        if (!balance.bounded(span.blow_up)) return trial.failure = "its energy grows without bound", false;
    }
    return true;
}

void run_trial(Trial& trial, const ParticleSet& start, const Span& span) {
    try {
        const auto simulation = make_simulation(trial.setup, ParticleSet(start));
        const Totals t = simulation->totals();
        const double fall = trial.setup.gravity.norm() * span.frames / span.fps;
        EnergyBalance balance(t, t.mass * fall * fall / 2);
        for (int frame = 0; frame < span.frames; ++frame)
            if (!take_frame(trial, *simulation, balance, span)) break;
        balance.store(trial);
        trial.x = positions(*simulation);
    } catch (const SimulationError& e) {
        trial.failure = e.what();
    }
}

// Mass on the nodes of a grid of spacing h, by linear weights.
static std::unordered_map<long long, double> mass_on_grid(const std::vector<double>& m, const std::vector<Vec3d>& x, double h) {
    std::unordered_map<long long, double> grid;
    for (std::size_t p = 0; p < x.size(); ++p) {
        const Vec3d X = x[p] / h, base = X.array().floor().matrix(), t = X - base;
        for (int corner = 0; corner < 8; ++corner) {
            double w = m[p];
            long long key = 0;
            for (int a = 0; a < 3; ++a) {
                const int up = corner >> a & 1;
                w *= up ? t(a) : 1 - t(a);
                key = key * 2097152 + static_cast<long long>(std::clamp(base(a), -1e6, 1e6)) + up + 1048576;
            }
            grid[key] += w;
        }
    }
    return grid;
}

Deviation deviation(const ParticleSet& start, const std::vector<Vec3d>& x, const std::vector<Vec3d>& reference, double h) {
    Deviation d;
    for (std::size_t p = 0; p < x.size(); ++p) {
        const double square = (x[p] - reference[p]).squaredNorm();
        d.root_mean_square += square / static_cast<double>(x.size());
        d.largest = std::max(d.largest, std::sqrt(square));
    }
    d.root_mean_square = std::sqrt(d.root_mean_square);
    auto mine = mass_on_grid(start.m, x, h);
    double total = 0;
    for (const auto& [node, mass] : mass_on_grid(start.m, reference, h)) mine[node] -= mass, total += mass;
    for (const auto& [node, difference] : mine) d.density += std::abs(difference) / total;
    return d;
}

}  // namespace firn
