#pragma once
#include "render/cover.h"

#include <algorithm>
#include <cmath>

// What a particle is drawn as that does not belong to unbroken snow: smaller, or a crumb, or powder.

namespace firn {

/// A particle that is powder in the air.
struct SprayPoint {
    float x, y, z;     ///< [m]
    float vx, vy, vz;  ///< [m/s]
    float amount;      ///< 0 to 1: how far it has come apart.
    float hash, value;
    float crumb;   ///< radius of what is too small for a splat of its own [m]; 0: none is.
    float puff;    ///< radius of the powder about it [m]: it fills the way to its neighbours,
    float powder;  ///< and hides so much of what is behind, as a share of what dense spray does [1].
};

inline float smoothstep(float a, float b, float x) {
    const float t = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/// How whole the snow around a particle is [1], 0 in the air to 1; ρ is the smoothed density, of which the
/// face of unbroken snow has a half, and a particle that is alone 0.016 at a cell's middle and 0.007 at its corner.
inline float wholeness(float rho, float flying) { return smoothstep(0.05f + 0.10f * flying, whole_from, rho); }

/// Of a splat [m]. The looser, the more unlike each other: few are large, and many fill the gaps.
inline float radius_of(float spacing, float whole, float hash) {
    const float h2 = hash * hash;
    return spacing * 0.85f * whole * std::lerp(0.55f + 1.0f * h2 * h2, 0.83f + 0.5f * h2, whole);
}

/// What a particle that lies alone has [m], 0: nothing. Few are large. What flies is powder for the most part, with crumbs in it whose
/// sizes are spread as broken pieces' are: as many are wider than r as r⁻² [Turcotte 1986]; none holds more than its particle.
/// `h`, 0 to 1, knows nothing of what else the hash decides.
inline float crumb_radius(float spacing, float flying, float hash, float h) {
    const float in_air = 0.04f / std::sqrt(h + 1e-4f);
    return std::lerp(radius_of(spacing, 0.16f + 0.40f * h * h, hash),
                     in_air < 0.1f ? 0 : spacing * std::min(in_air, 0.62f), flying);
}

/// Less than this [1] is of a particle that is alone, or has a neighbour at most: no cloud.
inline constexpr float lone_rho = 0.022f;

/// In a cloud of density ρ neighbours are ρ^(−1/3) apart: powder spreads as far, and where that is too far shows no more.
inline void spread_powder(SprayPoint& point, float spacing, float rho) {
    const float wider = std::clamp(std::cbrt(0.07f / std::max(rho, 1e-4f)), 1.0f, 2.2f);
    point.puff = 1.9f * spacing * wider;
    point.powder = point.amount / (wider * wider) * smoothstep(0.46f, 0.75f, 1 / wider);
}

/// `lone`, 0 to 1: in a dense cloud no grain's way can be told from its neighbours'.
inline SprayPoint spray_point(const ParticleView& particles, std::size_t p, float amount, float lone,
                              float hash, float crumb) {
    const float *x = &particles.x[3 * p], value = particles.value.empty() ? 0 : particles.value[p];
    SprayPoint point{x[0], x[1], x[2], 0, 0, 0, amount, hash, value, crumb, 0, 0};
    if (particles.v.empty() || !drawable(&particles.v[3 * p])) return point;
    const float* v = &particles.v[3 * p];
    point.vx = lone * v[0], point.vy = lone * v[1], point.vz = lone * v[2];
    return point;
}

}  // namespace firn
