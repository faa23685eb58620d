#include "app/particle_values.h"

#include "render/colour_map.h"
#include "sim/snow.h"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace firn {

bool needs_full_state(Colour colour) {
    return colour == Colour::density || colour == Colour::compression || colour == Colour::stress || colour == Colour::sleeping;
}

static void require(bool there, const char* what) {
    if (!there)
        throw PlyError(
            fmt::format("has no {}, which picture.colour shows; write them with --state full", what));
}

// The body that each particle belongs to.
static std::vector<std::size_t> bodies_of(std::size_t count, const std::vector<std::size_t>& bodies,
                                          std::size_t scene_bodies) {
    std::vector<std::size_t> result;
    if (scene_bodies == 1) result.assign(count, 0);
    else if (bodies.size() == scene_bodies)
        for (std::size_t b = 0; b < bodies.size() && bodies[b] <= count - result.size(); ++b)
            result.insert(result.end(), bodies[b], b);
    if (result.size() != count)
        throw PlyError("tells not of which body a particle is, which picture.colour shows; run.json does, where it is of "
                       "these particles and of a scene of as many bodies");
    return result;
}

static double von_mises(const Mat3d& Fe, double Jp, const Snow& snow) {
    const Mat3d sigma = kirchhoff_stress(left_strain(Fe), hardened(model(snow), Jp)).matrix() / determinant(Fe);
    const Mat3d deviator = sigma - sigma.trace() / 3 * Mat3d::Identity();
    return std::sqrt(1.5) * deviator.norm();
}

std::vector<double> particle_values(const PlyParticles& p, const Scene& scene,
                                    const std::vector<std::size_t>& bodies) {
    const Colour colour = scene.picture.colour;
    const std::size_t n = p.x.size();
    if (colour == Colour::snow) return {};
    if (colour == Colour::speed) require(p.v.size() == n, "velocities");
    const bool sleeps = scene.solver.rest_speed > 0;
    if (colour == Colour::sleeping && sleeps) require(p.asleep.size() == n, "asleep");
    if (colour != Colour::sleeping && needs_full_state(colour)) require(p.Jp.size() == n, "Jp");
    if (colour == Colour::density || colour == Colour::stress) require(p.Fe.size() == n, "Fe_00 to Fe_22");
    if (colour == Colour::density) require(p.mass.size() == n && p.volume.size() == n, "mass and volume");

    std::vector<std::size_t> body;
    if (colour == Colour::stress || colour == Colour::body) body = bodies_of(n, bodies, scene.bodies.size());
    std::vector<double> values(n);
    for (std::size_t i = 0; i < n; ++i) switch (colour) {
            case Colour::speed: values[i] = p.v[i].norm(); break;
            case Colour::density:
                values[i] = p.mass[i] / (p.volume[i] * p.Fe[i].determinant() * p.Jp[i]);
                break;
            case Colour::compression: values[i] = p.Jp[i]; break;
            case Colour::stress:
                values[i] = von_mises(p.Fe[i], p.Jp[i], scene.materials.at(scene.bodies[body[i]].material));
                break;
            case Colour::body: values[i] = static_cast<double>(body[i]); break;
            case Colour::particle_id: values[i] = static_cast<double>(i); break;
            case Colour::sleeping: values[i] = sleeps ? p.asleep[i] : 0; break;
            case Colour::snow: break;
        }
    return values;
}

// The next of 1, 2, 5, 10, … at or above x > 0.
static double round_up(double x) {
    const double unit = std::pow(10, std::floor(std::log10(x)));
    for (const double step : {1.0, 2.0, 5.0})
        if (x <= step * unit * (1 + 1e-9)) return step * unit;
    return 10 * unit;
}

ColourRange colour_range(const std::vector<double>& values, const Picture& picture) {
    std::vector<double> sorted;
    for (const double v : values)
        if (std::isfinite(v)) sorted.push_back(v);
    if (sorted.empty()) sorted = {0};
    const auto at = [&](double share) {
        const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(share * double(sorted.size() - 1));
        std::nth_element(sorted.begin(), place, sorted.end());
        return *place;
    };
    const double low = at(0.01), high = at(0.99);
    ColourRange range{0, 1};
    if (picture.colour == Colour::compression) {
        const double reach = std::min(round_up(std::max({1 - low, high - 1, 1e-3})), 1.0);  // J_P > 0
        range = {1 - reach, 1 + reach};
    } else if (picture.colour == Colour::sleeping) {
        range = {0, 1};
    } else if (picture.colour == Colour::body || picture.colour == Colour::particle_id) {
        range = {at(0), std::max(at(1), at(0) + 1)};
    } else if (high > 0) {
        range = {0, round_up(high)};
    }
    const double span = range.high - range.low;
    range = {picture.colour_min.value_or(range.low), picture.colour_max.value_or(range.high)};
    if (range.low >= range.high && !picture.colour_max) range.high = range.low + span;  // beyond all values
    if (range.low >= range.high && !picture.colour_min) range.low = range.high - span;
    return range;
}

}  // namespace firn
