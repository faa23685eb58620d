#pragma once
#include "render/camera.h"
#include "render/look.h"
#include "render/picture.h"
#include "sim/sampling.h"
#include "sim/settings.h"
#include "sim/snow.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace firn {

/// Snow at the start: a shape that is filled, or a file of particles.
struct SceneBody : Body {
    std::string material;       ///< name among the scene's materials.
    std::string particles;      ///< PLY file, relative to the scene's; empty: `shape` is filled.
    std::optional<Lumps> lumps; ///< none: even snow.
};

/// A scene as it is run: what its file says, with every default filled in.
struct Scene {
    std::string title;
    int frames = 48;                    ///< pictures after the first.
    double fps = 24;                    ///< frames a second of simulated time [1/s].
    double grid_spacing = 0;            ///< h [m].
    Vec3d gravity{0, -9.81, 0};         ///< [m/s²]
    std::uint64_t seed = 1;
    Solver solver;
    std::map<std::string, Snow> materials;
    std::vector<SceneBody> bodies;
    std::vector<Solid> colliders;
    std::optional<Camera> camera;       ///< none: one that frames the bodies and the ground under them.
    Picture picture;
};

}  // namespace firn
