#pragma once
#include "render/camera.h"
#include "render/image.h"
#include "render/look.h"
#include "render/picture.h"
#include "sim/particle_view.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn {

/// No usable OpenGL, or a call to it failed: says which, what was tried, and what to install or set.
struct GLError : std::runtime_error {
    using runtime_error::runtime_error;
};

/// Draws particles into pictures, off screen. Must be used from the thread that made it.
class Renderer {
public:
    explicit Renderer(const Picture&);  ///< Opens the context, compiles the shaders; throws GLError.
    ~Renderer();

    /// The particles from the camera, with camera and colliders where they are at `time` [s]. A plane collider is a
    /// ground as far as one sees. Any number of particles, none included, in metres within 10⁵ of the origin
    /// (others are left out); the same input gives the same bytes. Throws GLError, and std::invalid_argument
    /// for particles without a spacing or a collider of another shape than Collider allows.
    Image draw(const ParticleView&, const std::vector<Solid>&, const Camera&, double time);

    const std::string& description() const;  ///< vendor, renderer and version of the OpenGL in use.

private:
    struct Passes;
    std::unique_ptr<Passes> passes_;
};

/// A camera that sees the whole box (a body's bounds, say), from slightly above, for a scene that names none.
Camera framing(const Bounds&, double aspect_ratio);

}  // namespace firn
