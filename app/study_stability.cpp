#include "app/chart.h"
#include "app/files.h"
#include "app/interrupt.h"
#include "app/scene_keys.h"
#include "app/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace firn {

using Verdict = MapField::Verdict;

// A scene of T seconds is run with T/4 … T/512 a step.
constexpr int coarsest = 2, finest = 9;
constexpr double stiffness_factors[] = {1e-3, 1e-2, 1e-1, 1, 1e1, 1e2, 1e3};
constexpr double speed_factors[] = {0.1, 0.32, 1, 3.2, 10, 32};

constexpr double made_too_much = 0.1;       // energy made, in scales: a failure. Stable steps swing by about ω Δt/2.
constexpr double lost_too_much = 0.1;       // energy lost beyond what the smallest Δt loses, in scales

double explicit_limit(const Setup& setup) {
    double c = 0;
    for (const Snow& snow : setup.materials) {
        const SnowModel<double> m = model(snow);
        c = std::max(c, std::sqrt((m.lambda0 + 2 * m.mu0) / snow.rho));
    }
    return (setup.solver.weights == Weights::cubic ? 1.92 : 1.63) * setup.h / c;
}

static double duration_of(const Scene& scene) { return scene.frames / scene.fps; }

static double speed_of(const ParticleSet& start) {
    double speed = 0;
    for (const Vec3d& v : start.v) speed = std::max(speed, v.norm());
    return speed;
}

// What is stable in the row of one stiffness or speed: the trial with the smallest Δt is the measure.
static void judge(std::vector<MapField>& row) {
    const auto lost = [](const Trial& t) { return -t.energy / std::max(t.energy_scale, 1e-300); };
    const auto best = std::min_element(row.begin(), row.end(), [](const MapField& a, const MapField& b) { return a.dt < b.dt; });
    for (MapField& f : row) {
        const Trial& t = f.trial;
        const bool failed = !t.failure.empty() || t.rejected > 0 || t.energy_made > made_too_much * t.energy_scale;
        const bool measure = best->trial.failure.empty();
        f.verdict = failed                                                         ? Verdict::failed
                    : measure && std::abs(lost(t) - lost(best->trial)) > lost_too_much ? Verdict::lossy
                                                                                   : Verdict::stable;
    }
}

std::vector<MapField> stability_fields(const LoadedScene& loaded, const ParticleSet& start, Integrator integrator, bool stiffness) {
    const Scene& scene = loaded.scene;
    const Span span{1, 1 / duration_of(scene), 10};
    std::vector<MapField> all;
    const std::vector<double> factors = stiffness ? std::vector<double>(std::begin(stiffness_factors), std::end(stiffness_factors))
                                                  : std::vector<double>(std::begin(speed_factors), std::end(speed_factors));
    for (const double factor : factors) {
        Setup setup = make_setup(scene);
        setup.solver.integrator = integrator;
        ParticleSet particles = start;
        if (stiffness) for (Snow& snow : setup.materials) snow.E *= factor;
        else for (Vec3d& v : particles.v) v *= factor;
        const double along = stiffness ? setup.materials.front().E : factor * speed_of(start);
        std::vector<MapField> row;
        for (int k = coarsest; k <= finest && !interrupted(); ++k) {
            setup.solver.dt = duration_of(scene) / (1 << k);
            row.push_back({Verdict::stable, {}, *setup.solver.dt, along});
            row.back().trial.setup = setup;
            run_trial(row.back().trial, particles, span);
        }
        if (interrupted()) break;
        judge(row);
        all.insert(all.end(), row.begin(), row.end());
    }
    return all;
}

static const char* verdict_name(Verdict v) { return v == Verdict::stable ? "stable" : v == Verdict::lossy ? "lossy" : "failed"; }
static Color color_of(Verdict v) {
    return v == Verdict::stable ? Color{178, 216, 178} : v == Verdict::lossy ? Color{250, 225, 150} : Color{232, 160, 150};
}
// Half the distance to the neighbours in the sweep, as a factor.
static double half_step(const std::vector<MapField>& fields) {
    double next = 1e300, least = 1e300;
    for (const MapField& f : fields) least = std::min(least, f.along);
    for (const MapField& f : fields) if (f.along > least) next = std::min(next, f.along);
    return next < 1e300 ? std::sqrt(next / least) : 2;
}

static Chart map_of(const std::vector<MapField>& fields, const LoadedScene& loaded, bool stiffness) {
    Chart chart;
    chart.title = std::string(name_of(fields.front().trial.setup.solver.integrator)) + ": " + loaded.scene.title;
    chart.x_label = stiffness ? "Young's modulus E [Pa]" : "speed at the start [m/s]";
    chart.y_label = "dt [s]";
    chart.width = 600;
    const double side = half_step(fields), up = std::sqrt(2.0);
    double low = 1e300, high = 0, first = 1e300, last = 0;
    for (const MapField& f : fields) {
        chart.tiles.push_back({f.along / side, f.along * side, f.dt / up, f.dt * up, color_of(f.verdict)});
        low = std::min(low, f.dt / up), high = std::max(high, f.dt * up);
        first = std::min(first, f.along / side), last = std::max(last, f.along * side);
    }
    // Where theory has the limits, as far as the map reaches.
    const MapField& any = fields.front();
    Chart::Series sound{"explicit limit", {}, {20, 20, 20}, true, false, false};
    Chart::Series flow{stiffness ? "" : "h/v", {}, {20, 20, 160}, true, false, true};
    for (int i = 0; i <= 200; ++i) {
        const double along = first * std::pow(last / first, i / 200.0);
        const double limit = explicit_limit(any.trial.setup) * (stiffness ? std::sqrt(any.along / along) : 1);
        if (limit >= low && limit <= high) sound.points.push_back({along, limit, ""});
        const double cell = any.trial.setup.h / along;
        if (!stiffness && cell >= low && cell <= high) flow.points.push_back({along, cell, ""});
    }
    chart.series = {sound, flow};
    for (const auto v : {Verdict::stable, Verdict::lossy, Verdict::failed})
        chart.legend.push_back({verdict_name(v), {}, color_of(v), false});
    return chart;
}

static std::string csv_of(const std::vector<std::vector<MapField>>& maps, const char* along) {
    std::string text;
    for (const auto& fields : maps)
        for (const MapField& f : fields) {
            const Trial& t = f.trial;
            const double scale = std::max(t.energy_scale, 1e-300);
            text += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{},{},{},{:.6g},{:.6g}\n", name_of(t.setup.solver.integrator), along,
                                f.along, f.dt, explicit_limit(t.setup), verdict_name(f.verdict), t.steps, t.rejected,
                                t.energy / scale, t.energy_made / scale);
        }
    return text;
}

void write_stability(const std::filesystem::path& folder, const LoadedScene& loaded,
                     const std::vector<std::vector<MapField>>& by_stiffness, const std::vector<std::vector<MapField>>& by_speed) {
    write_file(folder / "stability.csv",
               {"integrator,along,value,dt,explicit_limit,verdict,steps,rejected,energy_change,energy_made\n" +
                csv_of(by_stiffness, "E") + csv_of(by_speed, "speed")});
    const auto maps = [&](const auto& all, bool stiffness) {
        std::vector<Chart> charts;
        for (const auto& fields : all) if (!fields.empty()) charts.push_back(map_of(fields, loaded, stiffness));
        return draw(charts);
    };
    write_drawing(folder, "stability_stiffness", maps(by_stiffness, true));
    write_drawing(folder, "stability_speed", maps(by_speed, false));
}

}  // namespace firn
