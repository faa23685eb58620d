#include "app/chart.h"
#include "app/files.h"
#include "app/scene_keys.h"
#include "app/study.h"
#include "render/png.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace firn {

// A trial beside what it differs from the reference.
struct Measured {
    const Trial* trial;
    Deviation deviation;
    bool failed() const { return !trial->failure.empty(); }
};

static std::string quoted(std::string text) {
    for (std::size_t at = 0; (at = text.find('"', at)) != std::string::npos; at += 2) text.insert(at, 1, '"');
    return "\"" + text + "\"";
}

static std::string csv(const std::vector<Measured>& all) {
    std::string text = "axis,setting,seconds,cpu_seconds,steps,iterations,rejected,unconverged,displacement_rms_m,"
                       "displacement_max_m,density_error,energy_change,energy_made,failed\n";
    for (const auto& m : all) {
        const Trial& t = *m.trial;
        text += fmt::format("{},{},{:.4g},{:.4g},{},{},{},{},", t.axis, quoted(t.name), t.seconds, t.cpu_seconds, t.steps, t.iterations, t.rejected, t.unconverged);
        text += m.failed() ? fmt::format(",,,,,{}\n", quoted(t.failure))
                           : fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},\n", m.deviation.root_mean_square,
                                         m.deviation.largest, m.deviation.density, t.energy / std::max(t.energy_scale, 1e-300),
                                         t.energy_made / std::max(t.energy_scale, 1e-300));
    }
    return text;
}

// The cheapest setting below each bound.
static std::string sentences(const std::vector<Measured>& all, double h) {
    std::string text;
    for (const double cells : {1.0, 0.3, 0.1, 0.03, 0.01, 0.003, 0.001}) {
        const Measured* best = nullptr;
        for (const auto& m : all)
            if (m.trial->axis != "reference" && !m.failed() && m.deviation.root_mean_square <= cells * h &&
                (!best || m.trial->cpu_seconds < best->trial->cpu_seconds))
                best = &m;
        const std::string bound = fmt::format("Within {:g} h ({:.3g} m, root mean square) of the reference", cells, cells * h);
        text += best ? fmt::format("{}, the cheapest is {}: {:.3g} s of processor time, {:.3g} times faster than the reference.\n",
                                   bound, best->trial->name, best->trial->cpu_seconds, all[0].trial->cpu_seconds / best->trial->cpu_seconds)
                     : fmt::format("{} there is none.\n", bound);
    }
    return text;
}

static Drawing trade(const std::vector<Measured>& all, const std::string& title) {
    Chart chart{title + ": error against time", "processor time of stepping [s]", "displacement error, root mean square [m]", {}, {}, {}, 1000, 640};
    std::map<std::string, std::size_t> places;
    for (const auto& m : all) {
        if (m.failed() || m.trial->axis == "reference") continue;
        const auto [at, fresh] = places.emplace(m.trial->axis, places.size());
        if (fresh) chart.series.push_back({m.trial->axis, {}, palette(at->second), false});
        chart.series[at->second].points.push_back({m.trial->cpu_seconds, m.deviation.root_mean_square, m.trial->name});
    }
    return draw(chart);
}

// Error over Δt for each integrator, with a line of first order through the smallest Δt of the first.
static Drawing order(const std::vector<Measured>& all, const std::string& title) {
    Chart chart{title + ": order in the time step", "dt [s]", "displacement error, root mean square [m]", {}, {}, {}};
    for (const auto& choice : choices(Integrator{})) {
        Chart::Series s{choice.name, {}, palette(chart.series.size())};
        for (const auto& m : all) {
            const Solver& solver = m.trial->setup.solver;
            const bool swept = m.trial->axis == "dt" || (m.trial->axis == "integrator" && solver.dt);
            if (swept && !m.failed() && solver.integrator == choice.value)
                s.points.push_back({*solver.dt, m.deviation.root_mean_square, ""});
        }
        if (!s.points.empty()) chart.series.push_back(s);
    }
    if (!chart.series.empty()) {
        const auto& points = chart.series.front().points;
        const auto& finest = *std::min_element(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x < b.x; });
        Chart::Series first{"first order", {}, {120, 120, 120}, true, false, true};
        for (const auto& p : points) first.points.push_back({p.x, finest.y * p.x / finest.x, ""});
        chart.series.push_back(first);
    }
    return draw(chart);
}

void write_drawing(const std::filesystem::path& folder, const std::string& name, const Drawing& drawing) {
    const std::string svg = to_svg(drawing);
    const auto png = encode_png(to_image(drawing), {{"Title", name}});
    write_file(folder / (name + ".svg"), {svg});
    write_file(folder / (name + ".png"), {{reinterpret_cast<const char*>(png.data()), png.size()}});
}

std::string write_study(const std::filesystem::path& folder, const LoadedScene& loaded, const ParticleSet& start,
                        const Trial& reference, const std::vector<Trial>& trials) {
    std::vector<Measured> all{{&reference, {}}};
    for (const auto& trial : trials) {
        all.push_back({&trial, {}});
        if (trial.failure.empty()) all.back().deviation = deviation(start, trial.x, reference.x, loaded.scene.grid_spacing);
    }
    const std::string says = sentences(all, loaded.scene.grid_spacing);
    write_file(folder / "study.csv", {csv(all)});
    write_file(folder / "study.txt", {says});
    write_drawing(folder, "trade", trade(all, loaded.scene.title));
    write_drawing(folder, "order", order(all, loaded.scene.title));
    return says;
}

}  // namespace firn
