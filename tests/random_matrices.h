#pragma once
#include "sim/types.h"

#include <random>

namespace firn {

/// Seeded source of test input.
struct RandomInput {
    std::mt19937_64 bits{20130118};
    std::normal_distribution<double> normal;
    double number() { return normal(bits); }
    Vec3d vector() { return {number(), number(), number()}; }
    Mat3d matrix() { Mat3d M; for (int i = 0; i < 9; ++i) M(i) = number(); return M; }
    Mat3d rotation() { return Eigen::Quaterniond(number(), number(), number(), number()).normalized().toRotationMatrix(); }
    /// Near the identity, det > 0: what snow sees.
    Mat3d deformation(double size = 0.1) {
        for (;;)
            if (const Mat3d F = Mat3d::Identity() + size * matrix(); F.determinant() > 0.1) return F;
    }
};

}  // namespace firn
