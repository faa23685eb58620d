#include "app/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace firn {

using Json = nlohmann::ordered_json;

void FrameRecord::add(const StepReport& report, double seconds) {
    dt_min = steps == 0 ? report.dt : std::min(dt_min, report.dt);
    dt_max = std::max(dt_max, report.dt);
    ++steps;
    solver_iterations += report.iterations;
    unconverged += !report.converged;
    rejected += report.rejected;
    if (!report.residuals.empty() && (residuals.empty() || report.residuals.back() > residuals.back()))
        residuals = report.residuals;
    simulate_seconds += seconds;
    peak_nodes = std::max(peak_nodes, report.nodes);
    nodes += report.nodes, stiff_nodes += report.stiff_nodes;
    simulated += report.dt;
    ledger += report.ledger;
    exchanges.resize(report.exchanges.size());
    for (std::size_t c = 0; c < exchanges.size(); ++c) exchanges[c] += report.exchanges[c];
    asleep = report.asleep;
}

static std::string share(long count, long all, const char* what) {
    return fmt::format("{} of {} {} ({:.2g} %)", count, all, what, 100.0 * double(count) / double(std::max(all, 1L)));
}

std::string Troubles::text() const {
    std::string all;
    if (rejected > 0) all += fmt::format("{} rejected", share(rejected, steps, "steps"));
    if (unconverged > 0) all += fmt::format("{}{} not converged", all.empty() ? "" : ", ", share(unconverged, steps, "solves"));
    return all.empty() ? all : "; " + all;
}

std::vector<std::string> Troubles::warnings() const {
    std::vector<std::string> all;
    if (100 * rejected > steps)
        all.push_back(fmt::format("warning: {} could have turned snow inside out and were rejected: each was taken again with half "
                                  "its length. A smaller solver.dt, solver.max_dt or solver.strain_limit needs fewer of them",
                                  share(rejected, steps, "steps")));
    if (100 * unconverged > steps)
        all.push_back(fmt::format("warning: {} did not converge: they ended after solver.max_iterations with a residual above "
                                  "solver.tolerance. Raise solver.max_iterations, or lower solver.max_dt", share(unconverged, steps, "solves")));
    return all;
}

FrameRecord& RunRecord::frame(int number) {
    const auto at = std::lower_bound(frames.begin(), frames.end(), number,
                                     [](const FrameRecord& r, int n) { return r.frame < n; });
    if (at != frames.end() && at->frame == number) return *at;
    FrameRecord made;
    made.frame = number;
    return *frames.insert(at, made);
}

std::string program_version() { return FIRN_VERSION; }

static Json list(const Vec3d& v) { return {v[0], v[1], v[2]}; }
static Vec3d vector_from(const Json& v) {
    return Vec3d(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>());
}

// The ledger's rows, each once: for writing and reading.
template <class F> static void each_row(auto&& ledger, F&& f) {
    f("gravity", ledger.gravity), f("to_grid", ledger.to_grid), f("integration", ledger.integration);
    f("contact", ledger.contact), f("plastic", ledger.plastic), f("to_particles", ledger.to_particles);
    f("sleep", ledger.sleep), f("removed", ledger.removed), f("added", ledger.added);
}

static Json ledger_json(const Ledger& ledger) {
    Json json = Json::object();
    each_row(ledger, [&](const char* name, double row) { json[name] = row; });
    return json;
}

// What passed between the snow and each collider: the mean force since the frame before, and the impulse, so that a run
// that is resumed goes on to the same numbers.
static Json colliders_json(const FrameRecord& r) {
    Json all = Json::array();
    for (const Exchange& e : r.exchanges) {
        const Vec3d force = r.simulated > 0 ? Vec3d(e.impulse / r.simulated) : Vec3d(0, 0, 0);
        all.push_back({{"name", fmt::format("collider_{}", all.size())}, {"velocity", list(e.velocity)}, {"force", list(force)},
                       {"impulse", list(e.impulse)}, {"work", e.work}});
    }
    return all;
}

Json to_json(const FrameRecord& r) {
    return {{"frame", r.frame},
            {"time", r.time},
            {"steps", r.steps},
            {"dt_min", r.dt_min},
            {"dt_max", r.dt_max},
            {"solver_iterations", r.solver_iterations},
            {"unconverged", r.unconverged},
            {"rejected", r.rejected},
            {"residuals", r.residuals},
            {"simulate_seconds", r.simulate_seconds},
            {"render_seconds", r.render_seconds},
            {"encode_seconds", r.encode_seconds},
            {"kinetic", r.totals.kinetic},
            {"elastic", r.totals.elastic},
            {"potential", r.totals.potential},
            {"momentum", list(r.totals.momentum)},
            {"angular_momentum", list(r.totals.angular_momentum)},
            {"mass", r.totals.mass},
            {"max_density", r.totals.max_density},
            {"peak_nodes", r.peak_nodes},
            {"nodes", r.steps > 0 ? double(r.nodes) / double(r.steps) : 0.0},
            {"stiff_nodes", r.steps > 0 ? double(r.stiff_nodes) / double(r.steps) : 0.0},
            {"asleep", r.asleep},
            {"simulated", r.simulated},
            {"ledger", ledger_json(r.ledger)},
            {"colliders", colliders_json(r)}};
}

// Throws for a number that is not whole, which get_to would convert even from outside the range.
static void read_whole(const Json& json, auto& out) {
    json.get_ref<const Json::number_integer_t&>();
    json.get_to(out);
}

FrameRecord frame_record_from(const Json& json) {
    FrameRecord r;
    read_whole(json.at("frame"), r.frame);
    json.at("time").get_to(r.time);
    read_whole(json.at("steps"), r.steps);
    json.at("dt_min").get_to(r.dt_min);
    json.at("dt_max").get_to(r.dt_max);
    read_whole(json.at("solver_iterations"), r.solver_iterations);
    read_whole(json.at("unconverged"), r.unconverged);
    read_whole(json.at("rejected"), r.rejected);
    json.at("residuals").get_to(r.residuals);
    json.at("simulate_seconds").get_to(r.simulate_seconds);
    json.at("render_seconds").get_to(r.render_seconds);
    json.at("encode_seconds").get_to(r.encode_seconds);
    json.at("kinetic").get_to(r.totals.kinetic);
    json.at("elastic").get_to(r.totals.elastic);
    json.at("potential").get_to(r.totals.potential);
    r.totals.momentum = vector_from(json.at("momentum"));
    r.totals.angular_momentum = vector_from(json.at("angular_momentum"));
    json.at("mass").get_to(r.totals.mass);
    read_whole(json.at("peak_nodes"), r.peak_nodes);
    if (json.contains("asleep")) read_whole(json.at("asleep"), r.asleep);
    if (!json.contains("ledger")) return r;     // of a version before there was one
    json.at("max_density").get_to(r.totals.max_density);
    const double steps = static_cast<double>(r.steps);
    r.nodes = static_cast<std::size_t>(std::llround(json.at("nodes").get<double>() * steps));
    r.stiff_nodes = static_cast<std::size_t>(std::llround(json.at("stiff_nodes").get<double>() * steps));
    json.at("simulated").get_to(r.simulated);
    each_row(r.ledger, [&](const char* name, double& row) { json.at("ledger").at(name).get_to(row); });
    for (const Json& c : json.at("colliders"))
        r.exchanges.push_back({vector_from(c.at("velocity")), vector_from(c.at("impulse")), c.at("work").get<double>()});
    return r;
}

Json to_json(const RunRecord& run) {
    const Machine machine = this_machine();
    Json frames = Json::array();
    for (const auto& record : run.frames) frames.push_back(to_json(record));
    return {{"program", "firn"}, {"version", program_version()}, {"scene", run.scene},
            {"scene_hash", run.scene_hash}, {"seed", run.seed}, {"threads", run.threads},
            {"machine", {{"cpu", machine.cpu}, {"cores", machine.cores}, {"memory", machine.memory}}},
            {"gl_renderer", run.gl_renderer ? Json(*run.gl_renderer) : Json()}, {"particles", run.particles}, {"body_particles", run.body_particles},
            {"frames", frames}};
}

RunRecord run_record_from(const Json& json) {
    RunRecord run;
    run.scene = json.at("scene");
    json.at("scene_hash").get_to(run.scene_hash);
    read_whole(json.at("seed"), run.seed);
    read_whole(json.at("threads"), run.threads);
    if (!json.at("gl_renderer").is_null()) run.gl_renderer = json.at("gl_renderer").get<std::string>();
    read_whole(json.at("particles"), run.particles);
    if (json.contains("body_particles"))
        for (const auto& count : json.at("body_particles")) read_whole(count, run.body_particles.emplace_back());
    for (const auto& record : json.at("frames")) run.frames.push_back(frame_record_from(record));
    return run;
}

}  // namespace firn
