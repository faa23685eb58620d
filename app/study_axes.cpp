#include "app/scene_keys.h"
#include "app/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

namespace firn {

constexpr double dt_factors[] = {4, 2, 1, 0.5, 0.25};
constexpr double reference_factor = 1.0 / 16;
constexpr double tolerance_factors[] = {100, 10, 0.1, 0.01, 0.001};

static std::string dt_text(double dt) { return fmt::format("{:.3g}", dt); }

using Trials = std::vector<Trial>;
using Axis = std::function<void(const Setup& own, double own_dt, bool with_dt, Trials&)>;

static void add(Trials& trials, const std::string& axis, const std::string& name, const Setup& setup) {
    trials.push_back({});
    trials.back().axis = axis, trials.back().name = name, trials.back().setup = setup;
}

static void along_dt(const Setup& own, double own_dt, bool, Trials& trials) {
    for (const double factor : dt_factors) {
        Setup s = own;
        s.solver.dt = factor * own_dt;
        add(trials, "dt", fmt::format("dt={}", dt_text(*s.solver.dt)), s);
    }
}

// Every other integrator with the scene's way to choose Δt and, where the study varies Δt, along it as well.
static void along_integrators(const Setup& own, double own_dt, bool with_dt, Trials& trials) {
    for (const auto& choice : choices(own.solver.integrator)) {
        if (choice.value == own.solver.integrator) continue;
        Setup s = own;
        s.solver.integrator = choice.value;
        add(trials, "integrator", fmt::format("integrator={}", choice.name), s);
        if (!with_dt) continue;
        for (const double factor : dt_factors) {
            s.solver.dt = factor * own_dt;
            add(trials, "integrator", fmt::format("{}, dt={}", choice.name, dt_text(*s.solver.dt)), s);
        }
    }
}

// Every other value of an enumeration.
template <class E> static void along_choices(const char* axis, E Solver::*member, const Setup& own, Trials& trials) {
    for (const auto& choice : choices(own.solver.*member)) {
        if (choice.value == own.solver.*member) continue;
        Setup s = own;
        s.solver.*member = choice.value;
        add(trials, axis, fmt::format("{}={}", axis, choice.name), s);
    }
}

static void along_tolerance(const Setup& own, double, bool, Trials& trials) {
    if (own.solver.integrator == Integrator::explicit_euler) return;    // has no solve
    for (const double factor : tolerance_factors) {
        Setup s = own;
        s.solver.tolerance = factor * own.solver.tolerance;
        if (s.solver.tolerance > 0.5) continue;
        s.solver.max_iterations = std::max(s.solver.max_iterations, factor < 1 ? 1000 : 0);
        add(trials, "tolerance", fmt::format("tolerance={:.3g}", s.solver.tolerance), s);
    }
}

static std::vector<std::pair<std::string, Axis>> all_axes() {
    return {{"dt", along_dt},
            {"integrator", along_integrators},
            {"precision", [](const Setup& s, double, bool, Trials& t) { along_choices("precision", &Solver::precision, s, t); }},
            {"weights", [](const Setup& s, double, bool, Trials& t) { along_choices("weights", &Solver::weights, s, t); }},
            {"transfer", [](const Setup& s, double, bool, Trials& t) { along_choices("transfer", &Solver::transfer, s, t); }},
            {"tolerance", along_tolerance}};
}

std::vector<std::string> axis_names() {
    std::vector<std::string> names;
    for (const auto& [name, axis] : all_axes()) names.push_back(name);
    return names;
}

Trials trials_along(const Setup& own, const std::vector<std::string>& axes, double own_dt) {
    Trials trials;
    const auto chosen = [&](const std::string& name) { return std::find(axes.begin(), axes.end(), name) != axes.end(); };
    for (const auto& [name, axis] : all_axes())
        if (chosen(name)) axis(own, own_dt, chosen("dt"), trials);
    return trials;
}

Trial reference_trial(const Setup& own, double own_dt) {
    Trial trial;
    trial.axis = "reference";
    trial.setup = own;
    Solver& s = trial.setup.solver;
    s.precision = Precision::twofold;
    s.dt = reference_factor * own_dt;
    s.tolerance = std::min(s.tolerance, 1e-8);
    s.max_iterations = std::max(s.max_iterations, 1000);
    trial.name = fmt::format("{}, double, dt={}", name_of(s.integrator), dt_text(*s.dt));
    return trial;
}

}  // namespace firn
