#pragma once
#include "sim/settings.h"

#include <Eigen/Core>

#include <vector>

namespace firn {

struct Vertex {
    Eigen::Vector3f position, normal;
};

/// Triangles (three vertices each) of a collider where it is at `time` [s]; none for a plane. Throws
/// std::invalid_argument for a shape that no collider can have.
std::vector<Vertex> triangles_of(const Collider&, double time);

}  // namespace firn
