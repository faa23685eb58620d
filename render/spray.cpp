#include "render/spray.h"

#include <algorithm>
#include <array>

namespace firn {

namespace {

enum Grains { points, either, lines };

/// As shaders/spray.vert has it for each grain, whose radius and place are known to a few per cent here.
Grains grains_of(const SprayPoint& point, const View& view, float spacing, float shutter,
                 float least_radius) {
    const Eigen::Vector3f at =
        view.basis.transpose() * (Eigen::Vector3f(point.x, point.y, point.z) - view.eye);
    if (at.z() < std::max(40 * spacing, view.near_depth)) return either;
    const float sample_width = at.z() * view.sample_tan;
    const Eigen::Vector3f way = view.basis.transpose() * Eigen::Vector3f(point.vx, point.vy, point.vz) *
                                (0.5f * shutter / sample_width);
    const float length = (way.head<2>() - way.z() / at.z() * at.head<2>()).norm();
    if (length < 1.8f * std::max(0.07f * spacing / sample_width, least_radius)) return points;
    const bool all_far = length > 2.2f * std::max(0.23f * spacing / sample_width, least_radius);
    return all_far && !(point.crumb > 0) ? lines : either;  // a crumb is always a point
}

}  // namespace

SpraySorted sorted_spray(const std::vector<SprayPoint>& spray, const View& view, float spacing, float shutter,
                         double edge, float puff_share) {
    std::vector<std::uint8_t> groups(spray.size());
    const auto count = static_cast<std::ptrdiff_t>(spray.size());
#pragma omp parallel for
    for (std::ptrdiff_t i = 0; i < count; ++i)
        groups[i] = static_cast<std::uint8_t>(
            (spray[i].hash < puff_share ? 0 : 3) +
            grains_of(spray[i], view, spacing, shutter, 0.55f * static_cast<float>(edge)));
    std::array<std::size_t, 7> ends{};
    for (const std::uint8_t group : groups) ++ends[group + 1];
    for (int i = 1; i < 7; ++i) ends[i] += ends[i - 1];
    SpraySorted sorted;
    sorted.with_puffs = {ends[0], ends[1], ends[2], ends[3]};
    sorted.without = {ends[3], ends[4], ends[5], ends[6]};
    sorted.all.resize(2 * spray.size());
    for (std::size_t i = 0; i < spray.size(); ++i) {
        const std::size_t to = ends[groups[i]]++;
        sorted.all[2 * to] = sorted.all[2 * to + 1] = spray[i];
    }
    return sorted;
}

}  // namespace firn
