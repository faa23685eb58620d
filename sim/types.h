#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace firn {

template <class Real> using Vec3 = Eigen::Matrix<Real, 3, 1>;
template <class Real> using Mat3 = Eigen::Matrix<Real, 3, 3>;
using Vec3d = Vec3<double>;
using Mat3d = Mat3<double>;
using Vec3i = Eigen::Vector3i;

}  // namespace firn
