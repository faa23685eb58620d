#include "app/estimate.h"

#include "app/machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace firn {

constexpr double usable = 0.9;              // share of free memory that a run may take
constexpr double probe_particles = 3e5;     // a probe with more than that would take long itself

std::string bytes_text(double bytes) {
    const char* const units[] = {"bytes", "kB", "MB", "GB", "TB"};
    int unit = 0;
    while (bytes >= 999.5 && unit < 4) bytes /= 1000, ++unit;
    return bytes < 1e5 ? fmt::format("{:.3g} {}", bytes, units[unit])
                       : fmt::format("{:.1e} {}", bytes, units[unit]);
}

static double bytes_per_start() {  // of a ParticleSet
    return sizeof(Vec3d) * 2 + sizeof(double) * 3 + sizeof(Mat3d) + 1;
}

// The libraries, and the renderer's buffers for a sample: colour, depth, normals and smoothing, each twice.
static double picture_memory(const Picture& picture) {
    const double samples = picture.quality == Quality::final ? 4 : 1;
    return 150e6 + picture.width * static_cast<double>(picture.height) * (samples * 64 + 3 * 6);
}

// Bytes of a PNG [of 3 a pixel], as snow scenes compress.
static double picture_file(const Picture& picture) { return 3000 + 0.8 * picture.width * picture.height; }

Needs needs_of(const LoadedScene& loaded, double particles, double nodes, const RunFiles& files) {
    const Solver& solver = loaded.scene.solver;
    const double state = static_cast<double>(bytes_per_particle(solver));
    const double real = solver.precision == Precision::single ? 4 : 8;
    const double waiting =
        6 * (files.pictures ? 24.0 : 0.0) + 4 * real * files.columns;  // frames in the queues
    Needs needs{particles, nodes, files.pictures ? picture_memory(loaded.scene.picture) : 0, 0, 0};
    needs.memory =
        20e6 + particles * (state * 2 + bytes_per_start() + waiting) +  // twice: a checkpoint in the making
        nodes * static_cast<double>(bytes_per_node(solver)) +
        needs.pictures + (files.pictures ? particles * 60 : 0);
    const double frames = files.last_frame - files.first_frame + 1.0;
    needs.disk = particles * state + 700 * frames +
                 frames * (files.pictures ? picture_file(loaded.scene.picture) : 0) +
                 frames * particles * real * files.columns;
    return needs;
}

// h grown so that memory shrinks by the factor (particles go with 1/h³), as two digits, rounded up.
static double coarser(double h, double factor) {
    const double wanted = h * std::cbrt(factor) * 1.02;
    const double digit = std::pow(10, std::floor(std::log10(wanted)) - 1);
    return std::ceil(wanted / digit) * digit;
}

void require_picture_memory(const Picture& picture, const std::string& path, double rest) {
    const double memory = usable * static_cast<double>(available_memory()), needed = picture_memory(picture);
    if (needed > memory - std::min(rest, 0.5 * memory))
        throw ResourceError(fmt::format(
            "{}: pictures of {}×{} need about {} of memory, but {} can be used: set picture.width and picture.height to less", path,
            picture.width, picture.height, bytes_text(needed), bytes_text(memory)));
}

void require_resources(const LoadedScene& loaded, const Needs& needs, const std::filesystem::path& output) {
    const double memory = usable * static_cast<double>(available_memory());
    const double disk = static_cast<double>(available_disk(output));
    if (needs.memory > memory) {
        if (needs.pictures > 0) require_picture_memory(loaded.scene.picture, loaded.path, needs.memory - needs.pictures);
        const bool sampled = loaded.files.size() < loaded.scene.bodies.size();
        const double h = coarser(loaded.scene.grid_spacing,
                                 (needs.memory - needs.pictures) / std::max(memory - needs.pictures - 2e8, 1e6));
        throw ResourceError(fmt::format(
            "{}: needs about {} of memory for {:.3g} particles and {:.3g} grid nodes, but {} can be used: {}",
            loaded.path, bytes_text(needs.memory), needs.particles, needs.nodes, bytes_text(memory),
            sampled ? fmt::format("set grid_spacing to {:.2g} or more, or fewer particles_per_cell", h)
                    : "give it fewer particles"));
    }
    if (needs.disk > disk)
        throw ResourceError(
            fmt::format("{}: needs about {} of disk, but {} are free where {} lies: choose another disk "
                        "with -o, fewer frames (--frames), or a smaller picture",
                        loaded.path, bytes_text(needs.disk), bytes_text(disk), output.string()));
}

void require_resources_for_count(const LoadedScene& loaded, const RunFiles& files,
                                 const std::filesystem::path& output) {
    const double count = expected_particles(loaded);
    double per_cell = 1e-3;
    for (const auto& body : loaded.scene.bodies) per_cell = std::max(per_cell, body.particles_per_cell);
    require_resources(loaded, needs_of(loaded, count, count / per_cell, files), output);
}

// What a simulation on a grid of edge h tells when it takes a few steps.
struct Probe {
    double seconds;                     // a step takes
    std::vector<std::string> warnings;
};
static Probe probe(const LoadedScene& loaded, double h, const StartingParticles& begin) {
    using Clock = std::chrono::steady_clock;
    const auto since = [](Clock::time_point t) {
        return std::chrono::duration<double>(Clock::now() - t).count();
    };
    Setup setup = make_setup(loaded.scene);
    setup.h = h;
    const auto simulation = make_simulation(setup, ParticleSet(begin.particles));
    Probe result{0, volume_warnings(loaded, begin.counts, begin.volumes, simulation->volumes(), h)};
    if (loaded.scene.frames == 0) return result;
    const double frame = 1 / loaded.scene.fps;
    simulation->step(frame);  // the first one also sorts and measures volumes
    const auto start = Clock::now();
    int steps = 0;
    do simulation->step(frame), ++steps;
    while (steps < 20 && since(start) < 0.5);
    result.seconds = since(start) / steps;
    return result;
}

// Seconds to draw and encode a picture on two cores without a GPU.
static double picture_seconds(const Picture& picture, double particles) {
    const double samples = picture.quality == Quality::final ? 4 : 1;
    return 0.03 + picture.motion_samples * (2.5e-7 * picture.width * picture.height * samples + 4e-7 * particles);
}

Estimate estimate(const LoadedScene& loaded, const std::filesystem::path& output) {
    const Scene& scene = loaded.scene;
    const RunFiles files{0, scene.frames, true, 0};
    require_resources_for_count(loaded, files, output);
    const double expected = expected_particles(loaded), duration = scene.frames / scene.fps;
    const double shrink =
        std::max(1.0, expected / probe_particles);  // the probe has that many times fewer particles
    const double h = scene.grid_spacing * std::cbrt(shrink);
    const StartingParticles start = make_particles(loaded, h);
    const double scale = std::max(1.0, expected / static_cast<double>(start.particles.size()));
    const double particles = static_cast<double>(start.particles.size()) * scale;
    const double nodes = static_cast<double>(count_nodes(start.particles, h, scene.solver.weights)) * scale;
    Estimate result{needs_of(loaded, particles, nodes, files), 0, 0, start.warnings};
    require_resources(loaded, result.needs, output);
    result.steps = std::max(estimate_steps(make_setup(scene), start.particles, duration), 1.0 * scene.frames);
    const Probe probed = probe(loaded, h, start);
    result.warnings.insert(result.warnings.end(), probed.warnings.begin(), probed.warnings.end());
    result.seconds = result.steps * probed.seconds * scale + (scene.frames + 1) * picture_seconds(scene.picture, particles);
    return result;
}

}  // namespace firn
