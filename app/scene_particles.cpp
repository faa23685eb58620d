#include "app/scene_particles.h"

#include "sim/lumps.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>

namespace firn {

Setup make_setup(const Scene& scene) {
    Setup setup{scene.grid_spacing, scene.gravity, scene.solver, {}, {}};
    setup.colliders.assign(scene.colliders.begin(), scene.colliders.end());
    for (const auto& [name, snow] : scene.materials) setup.materials.push_back(snow);
    return setup;
}

double expected_particles(const LoadedScene& loaded) {
    double count = 0;
    for (std::size_t i = 0; i < loaded.scene.bodies.size(); ++i) {
        const auto file = loaded.files.find(i);
        count += file != loaded.files.end()
                     ? static_cast<double>(file->second.x.size())
                     : expected_count(loaded.scene.bodies[i], loaded.scene.grid_spacing);
    }
    return count;
}

static Vec3d centre_of_mass(const ParticleSet& set) {
    Vec3d sum = Vec3d::Zero();
    double mass = 0;
    for (std::size_t p = 0; p < set.size(); ++p) sum += set.m[p] * set.x[p], mass += set.m[p];
    return mass > 0 ? Vec3d(sum / mass) : sum;
}

// Particles from a file, completed with what the body says.
static ParticleSet from_file(const PlyParticles& file, const SceneBody& body, double rho, double h,
                             std::uint8_t material) {
    const std::size_t n = file.x.size();
    ParticleSet set;
    set.x = file.x;
    set.m = file.mass.empty() ? std::vector<double>(n, rho * h * h * h / body.particles_per_cell) : file.mass;
    set.v = file.v.empty() ? std::vector<Vec3d>(n, Vec3d::Zero()) : file.v;
    set.V0 = file.volume.empty() ? std::vector<double>(n, 0.0) : file.volume;
    set.Jp = file.Jp.empty() ? std::vector<double>(n, 1.0) : file.Jp;
    set.Fe = file.Fe.empty() ? std::vector<Mat3d>(n, Mat3d::Identity()) : file.Fe;
    set.material.assign(n, material);
    const Vec3d centre = centre_of_mass(set);
    for (std::size_t p = 0; p < n; ++p)
        set.v[p] += body.velocity + body.angular_velocity.cross(set.x[p] - centre);
    return set;
}

static ParticleSet make_body(const LoadedScene& loaded, std::size_t i, double h) {
    const SceneBody& body = loaded.scene.bodies[i];
    const auto& materials = loaded.scene.materials;
    const auto material = materials.find(body.material);
    const auto index = static_cast<std::uint8_t>(std::distance(materials.begin(), material));
    const auto file = loaded.files.find(i);
    ParticleSet set = file != loaded.files.end()
                          ? from_file(file->second, body, material->second.rho, h, index)
                          : sample(body, material->second.rho, h, loaded.scene.seed + i, index);
    if (!body.lumps) return set;
    const Vec3d even = centre_of_mass(set);
    pack_in_lumps(set, *body.lumps, loaded.scene.seed + i);
    const Vec3d shift = body.angular_velocity.cross(even - centre_of_mass(set));  // it turns about its own centre
    for (Vec3d& v : set.v) v += shift;
    return set;
}

// The share of a body's particles that lie inside the shape, from 2000 of them.
static double share_inside(const ParticleSet& set, const Shape& shape) {
    const std::size_t stride = set.size() / 2000 + 1;
    double inside = 0, tried = 0;
    for (std::size_t p = 0; p < set.size(); p += stride, ++tried)
        inside += signed_distance(shape, set.x[p]) < 0;
    return tried > 0 ? inside / tried : 0;
}

static Bounds bounds_of(const ParticleSet& set) {
    Bounds box;
    for (const Vec3d& x : set.x) box.extend(x);
    return box;
}

static bool overlap(const Bounds& a, const Bounds& b) {
    return (a.lower.array() <= b.upper.array() && b.lower.array() <= a.upper.array()).all();
}

static std::vector<std::string> overlaps(const LoadedScene& loaded, const ParticleSet& set, std::size_t i) {
    std::vector<std::string> warnings;
    const auto& scene = loaded.scene;
    const Place place = loaded.read.place(fmt::format("bodies.{}", i));
    const auto warn = [&](double share, const std::string& other, const char* consequence) {
        if (share > 0)
            warnings.push_back(
                fmt::format("{}:{}:{}: bodies.{}: warning: about {:.3g} % of it lies inside {}; {}",
                            loaded.path, place.line, place.column, i, 100 * share, other, consequence));
    };
    for (std::size_t c = 0; c < scene.colliders.size(); ++c)
        warn(share_inside(set, scene.colliders[c].shape), fmt::format("colliders.{}", c),
             "it cannot leave by itself");
    const Bounds box = bounds_of(set);
    for (std::size_t j = 0; j < i; ++j)
        if (scene.bodies[j].particles.empty() && overlap(box, bounds(scene.bodies[j].shape)))
            warn(share_inside(set, scene.bodies[j].shape), fmt::format("bodies.{}", j),
                 "snow is twice as dense there");
    return warnings;
}

// A float resolves 1/64 of a cell at 2¹⁸ cells from the origin; the grid's indices end at about 2³⁰.
static double farthest_coordinate(const Scene& scene) {
    return (scene.solver.precision == Precision::single ? 0x1p18 : 0x1p30) * scene.grid_spacing;
}

static bool is_near(const ParticleSet& set, double farthest) {
    return std::all_of(set.x.begin(), set.x.end(),
                       [&](const Vec3d& x) { return x.cwiseAbs().maxCoeff() <= farthest; });
}

// Shapes of next to no volume, and so much surface that sampling would take hours.
static void check_tries(const LoadedScene& loaded, Problems& problems) {
    constexpr double most = 5e9;  // about a minute
    for (std::size_t i = 0; i < loaded.scene.bodies.size(); ++i) {
        const SceneBody& body = loaded.scene.bodies[i];
        const std::string path = fmt::format("bodies.{}.shape", i);
        if (loaded.files.contains(i) || tries(body, loaded.scene.grid_spacing, most) < most) continue;
        problems.add(loaded.read.place(path), path,
                     fmt::format("has so much surface that more than {:.0e} points would be tried for {:.1e} particles; set a larger "
                                 "grid_spacing, or make it smaller", most, expected_count(body, loaded.scene.grid_spacing)));
    }
    problems.throw_if_any();
}

StartingParticles make_particles(const LoadedScene& loaded, double h) {
    StartingParticles start;
    Problems problems;
    check_tries(loaded, problems);
    for (std::size_t i = 0; i < loaded.scene.bodies.size(); ++i) {
        const ParticleSet set = make_body(loaded, i, h);
        const std::string path = fmt::format("bodies.{}", i);
        const bool filled = loaded.scene.bodies[i].particles.empty();
        const SceneBody& body = loaded.scene.bodies[i];
        const double rho = loaded.scene.materials.at(body.material).rho, volume = std::accumulate(set.m.begin(), set.m.end(), 0.0) / rho;
        const double expected = volume / (h * h * h) * body.particles_per_cell;
        if (filled && expected > 20 && set.size() > 0 && static_cast<double>(set.size()) < 0.5 * expected)
            problems.add(loaded.read.place(path), path, fmt::format(
                "is thinner than its particles are apart, {:.2g} m: make it thicker, or set a smaller grid_spacing or more particles_per_cell",
                h / std::cbrt(body.particles_per_cell)));
        if (set.size() == 0 && h == loaded.scene.grid_spacing)
            problems.add(loaded.read.place(path), path,
                         filled
                             ? "has no particles; it must be larger than a few grid_spacing, or have more particles_per_cell"
                             : fmt::format("has no particles: there are none in {}", loaded.scene.bodies[i].particles));
        if (const double farthest = farthest_coordinate(loaded.scene); !is_near(set, farthest))
            problems.add(
                loaded.read.place(path), path,
                fmt::format("reaches farther from the origin than {:g} m, which this grid_spacing cannot "
                            "resolve; move it nearer, or set solver.precision: double",
                            farthest));
        for (auto& warning : overlaps(loaded, set, i)) start.warnings.push_back(warning);
        start.particles.append(set);
        start.counts.push_back(set.size());
        start.volumes.push_back(volume);
    }
    problems.throw_if_any();
    return start;
}

std::vector<std::string> volume_warnings(const LoadedScene& loaded, const std::vector<std::size_t>& counts,
                                         const std::vector<double>& volumes, const std::vector<float>& V0, double h) {
    std::vector<std::string> warnings;
    auto next = V0.begin();
    for (std::size_t i = 0; i < counts.size(); ++i) {
        const auto end = next + static_cast<std::ptrdiff_t>(counts[i]);
        const double found = std::accumulate(next, end, 0.0) / volumes[i];
        next = end;
        // What a grid adds lies within a cell or two of where snow ends: a share that goes with h.
        const double ratio = 1 + (found - 1) * loaded.scene.grid_spacing / h;
        if (!(std::abs(ratio - 1) > 0.2)) continue;  // NaN: of no particles
        const auto file = loaded.files.find(i);
        const bool own = file != loaded.files.end() && !file->second.volume.empty();
        const Place place = loaded.read.place(fmt::format("bodies.{}", i));
        warnings.push_back(fmt::format(
            "{}:{}:{}: bodies.{}: warning: its particles have {:.3g} times the volume that their mass has at the "
            "material's rho, and are about as many times as stiff; {}",
            loaded.path, place.line, place.column, i, ratio,
            own ? fmt::format("set rho to {:.3g}, or take the volumes out of the file",
                              loaded.scene.materials.at(loaded.scene.bodies[i].material).rho / ratio)
                : "set solver.initial_volume: sampled"));
    }
    return warnings;
}

}  // namespace firn
