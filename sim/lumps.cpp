#include "sim/lumps.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

// Compiled without contraction of a·b + c, as sampling.cpp: the same seed gives the same lumps on every machine.

namespace firn {
namespace {

/// Mixes all bits [splitmix64, Steele et al. 2014].
std::uint64_t mixed(std::uint64_t a) {
    a = (a ^ (a >> 30)) * 0xbf58476d1ce4e5b9u;
    a = (a ^ (a >> 27)) * 0x94d049bb133111ebu;
    return a ^ (a >> 31);
}

std::uint64_t number_of(const Vec3d& cell, std::uint64_t seed) {
    std::uint64_t number = seed;
    for (int a = 0; a < 3; ++a)
        number = mixed(number + 0x9e3779b97f4a7c15u + std::bit_cast<std::uint64_t>(cell(a)));
    return number;
}

/// [0, 1), 21 bits of the number.
double uniform(std::uint64_t number, int which) {
    return static_cast<double>((number >> (21 * which)) & 0x1fffff) * 0x1p-21;
}

/// Where a place lies among Voronoi cells; lengths in cells' mean widths.
struct Lump {
    double depth = 0;          ///< distance to the nearest face.
    std::uint64_t number = 0;  ///< of the cell, random.
};

Lump lump_at(const Vec3d& x, std::uint64_t seed) {
    const Vec3d cell = x.array().floor();
    std::array<Vec3d, 125> points;  // one in each cell: the nearest is within √3; beyond two cells none matters
    Lump lump{std::numeric_limits<double>::infinity()};
    double least = lump.depth;
    int own = 0;
    for (int i = 0; i < 125; ++i) {
        const Vec3d at = cell + Vec3d(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2);
        const std::uint64_t number = number_of(at, seed);
        points[i] = at + Vec3d(uniform(number, 0), uniform(number, 1), uniform(number, 2));
        const double distance = (points[i] - x).squaredNorm();
        if (distance < least) least = distance, own = i, lump.number = number;
    }
    for (int i = 0; i < 125; ++i) {  // to the plane half way between two points
        const double gap = (points[i] - x).squaredNorm() - least, apart = (points[i] - points[own]).norm();
        if (apart > 0) lump.depth = std::min(lump.depth, gap / (2 * apart));
    }
    return lump;
}

}  // namespace

double packed_Jp(const Lumps& lumps, const Vec3d& x, std::uint64_t seed) {
    constexpr int levels = 3;  // each of half the width
    // Share of lumps that are no firmer between those they are made of; of a seam's weakness, what the others have there,
    // and what the weakest lump has within; from a face to where snow is as firm as that, as a share of lumps' width.
    constexpr double coming_apart = 0.4, held = 0.25, unlike = 0.3, seam_width = 0.028;
    double weakness = 0, seam = 1, width = 1;
    for (int level = 0; level < levels; ++level, width /= 2) {
        const Lump lump = lump_at(x / (width * lumps.size), mixed(levels * seed + level));
        const double inside = std::min(lump.depth * width / seam_width, 1.0),
                     own = unlike * uniform(mixed(lump.number), 0);
        weakness = std::max(weakness, seam * (1 - (1 - own) * inside));
        if (uniform(mixed(lump.number), 1) >= coming_apart) seam *= held;
    }
    return lumps.core + (lumps.seam - lumps.core) * weakness;
}

void pack_in_lumps(ParticleSet& set, const Lumps& lumps, std::uint64_t seed) {
#pragma omp parallel for
    for (std::ptrdiff_t p = 0; p < static_cast<std::ptrdiff_t>(set.size()); ++p) {
        const double Jp = packed_Jp(lumps, set.x[p], seed);
        set.Jp[p] *= Jp, set.m[p] /= Jp, set.V0[p] /= Jp;
    }
}

}  // namespace firn
