#pragma once
#include "sim/simulation.h"

#include <omp.h>

#include <algorithm>
#include <cstring>

/// One thread while it lives: a second one costs a hundred particles more than it brings.
struct OneThread {
    int usual = omp_get_max_threads();
    OneThread() { omp_set_num_threads(1); }
    ~OneThread() { omp_set_num_threads(usual); }
    OneThread(const OneThread&) = delete;
    OneThread& operator=(const OneThread&) = delete;
};

/// Column `name` of particle p.
inline double value(const firn::ParticleRows& rows, std::size_t p, const std::string& name) {
    const auto c = std::find(rows.columns.begin(), rows.columns.end(), name) - rows.columns.begin();
    const std::size_t at = p * rows.columns.size() + static_cast<std::size_t>(c);
    if (rows.twofold) {
        double d;
        std::memcpy(&d, rows.data.data() + 8 * at, 8);
        return d;
    }
    float f;
    std::memcpy(&f, rows.data.data() + 4 * at, 4);
    return f;
}

inline firn::Vec3d position(const firn::ParticleRows& rows, std::size_t p) {
    return {value(rows, p, "x"), value(rows, p, "y"), value(rows, p, "z")};
}
inline firn::Vec3d velocity(const firn::ParticleRows& rows, std::size_t p) {
    return {value(rows, p, "vx"), value(rows, p, "vy"), value(rows, p, "vz")};
}

/// The state of `rows(true)` as a start: everything but the affine velocities.
inline firn::ParticleSet start_from(const firn::ParticleRows& rows) {
    firn::ParticleSet set;
    for (std::size_t p = 0; p < rows.count; ++p) {
        firn::Mat3d Fe;
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) Fe(a, b) = value(rows, p, "Fe_" + std::to_string(a) + std::to_string(b));
        set.x.push_back(position(rows, p)), set.v.push_back(velocity(rows, p)), set.Fe.push_back(Fe);
        set.m.push_back(value(rows, p, "mass")), set.V0.push_back(value(rows, p, "volume"));
        set.Jp.push_back(value(rows, p, "Jp")), set.material.push_back(0);
    }
    return set;
}
