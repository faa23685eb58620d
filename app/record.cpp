#include "app/record.h"

#include <algorithm>

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
    asleep = report.asleep;
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
            {"peak_nodes", r.peak_nodes},
            {"asleep", r.asleep}};
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
