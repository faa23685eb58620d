#include "app/pipeline.h"

#include "app/files.h"
#include "app/particle_values.h"
#include "render/caption.h"
#include "render/png.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace firn {

using Clock = std::chrono::steady_clock;

static double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

// Mean distance of neighbours where the bodies are sampled most sparsely [m].
static float mean_spacing(const Scene& scene) {
    double per_cell = scene.bodies.front().particles_per_cell;
    for (const auto& body : scene.bodies) per_cell = std::min(per_cell, body.particles_per_cell);
    return static_cast<float>(scene.grid_spacing / std::cbrt(per_cell));
}

template <class T> static std::string_view bytes_of(const std::vector<T>& data) {
    return {reinterpret_cast<const char*>(data.data()), data.size() * sizeof(T)};
}

Pipeline::Pipeline(const Scene& scene, OutputFolder folder, RunRecord record, bool pictures)
    : scene_(scene), folder_(std::move(folder)), record_(std::move(record)), spacing_(mean_spacing(scene)) {
    if (pictures) {
        std::promise<std::string> opened;
        auto description = opened.get_future();
        drawer_ =
            std::thread([this, promise = std::move(opened)]() mutable { draw_all(std::move(promise)); });
        try {
            record_.gl_renderer = description.get();
        } catch (...) {
            drawer_.join();
            throw;
        }
    }
    writer_ = std::thread([this] { write_all(); });
}

Pipeline::~Pipeline() {
    to_draw_.cancel();
    to_write_.cancel();
    if (drawer_.joinable()) drawer_.join();
    if (writer_.joinable()) writer_.join();
}

bool Pipeline::push(Job&& job) { return (drawer_.joinable() ? to_draw_ : to_write_).push(std::move(job)); }

void Pipeline::finish() {
    to_draw_.close();
    if (drawer_.joinable()) drawer_.join();
    to_write_.close();
    if (writer_.joinable()) writer_.join();
    if (error_) std::rethrow_exception(error_);
    write_run_json();
}

void Pipeline::fail(std::exception_ptr error) {
    {
        const std::lock_guard lock(error_mutex_);
        if (!error_) error_ = error;
    }
    to_draw_.cancel();
    to_write_.cancel();
}

void Pipeline::draw_all(std::promise<std::string> opened) {
    std::optional<Renderer> renderer;
    try {
        renderer.emplace(scene_.picture);
        opened.set_value(renderer->description());
    } catch (...) {
        opened.set_exception(std::current_exception());
        return;
    }
    try {
        while (auto job = to_draw_.pop()) {
            if (auto* frame = std::get_if<FrameJob>(&*job); frame && frame->picture) draw(*frame, *renderer);
            if (!to_write_.push(std::move(*job))) return;
        }
    } catch (...) {
        fail(std::current_exception());
    }
}

static std::vector<std::string> overlay_of(const FrameRecord& record, std::size_t particles) {
    std::vector<std::string> lines{fmt::format("t = {:.4f} s", record.time)};
    if (record.dt_max > 0) lines.push_back(fmt::format("dt = {:.2e} to {:.2e} s", record.dt_min, record.dt_max));
    lines.push_back(fmt::format("{} particles", particles));
    return lines;
}

void Pipeline::draw(FrameJob& job, Renderer& renderer) const {
    const auto start = Clock::now();
    const Picture& picture = scene_.picture;
    const ColourRange range = colour_range(job.values, picture);
    std::vector<float> shares;
    for (const double value : job.values) shares.push_back(static_cast<float>(range.share(value)));
    const ParticleView view{job.x, job.v, spacing_, shares, static_cast<float>(scene_.grid_spacing)};
    job.image = renderer.draw(view, scene_.colliders, *scene_.camera, job.record.time);
    if (picture.colour != Colour::snow) draw_legend(job.image, picture.colour, range);
    if (picture.overlay) draw_text(job.image, overlay_of(job.record, job.x.size() / 3));
    job.x = job.v = {};
    job.values = {};
    job.record.render_seconds = seconds_since(start);
}

void Pipeline::write_all() {
    try {
        while (auto job = to_write_.pop()) {
            if (auto* frame = std::get_if<FrameJob>(&*job)) {
                write(*frame);
                continue;
            }
            Checkpoint& checkpoint = std::get<Checkpoint>(*job);
            checkpoint.frames.clear();
            for (const auto& record : record_.frames)
                if (record.frame <= checkpoint.frame) checkpoint.frames.push_back(record);
            write_checkpoint(folder_.checkpoint(), checkpoint);
        }
    } catch (...) {
        fail(std::current_exception());
    }
}

void Pipeline::write(FrameJob& job) {
    const auto start = Clock::now();
    if (job.rows)
        write_file(folder_.particles(job.record.frame), {ply_header(*job.rows), bytes_of(job.rows->data)});
    if (job.picture) {
        const auto png = encode_png(job.image, {{"Title", scene_.title},
                                                {"Frame", std::to_string(job.record.frame)},
                                                {"Time", fmt::format("{}", job.record.time)},
                                                {"Software", "firn " + program_version()},
                                                {"Scene-Hash", record_.scene_hash}});
        write_file(folder_.picture(job.record.frame), {bytes_of(png)});
    }
    job.record.encode_seconds = seconds_since(start);
    record_.frame(job.record.frame) = job.record;
    if (seconds_since(json_written_) > json_pause_) write_run_json();
}

void Pipeline::write_run_json() {
    const auto start = Clock::now();
    write_file(folder_.run_json(), {to_json(record_).dump(2) + "\n"});
    json_written_ = Clock::now();
    json_pause_ = std::max(1.0, 20 * seconds_since(start));
}

}  // namespace firn
