#pragma once
#include "sim/settings.h"

namespace firn {

/// What a collider is drawn as (shaders/look_*.glsl).
enum class Look { snow, ice, soil, wood, tiles, concrete, metal, glass, automatic };

/// A collider as it is drawn.
struct Solid : Collider {
    Look look = Look::automatic;  ///< automatic: a plane that one can stand on is snow, all else is concrete.
};

Look shown_look(const Solid&);

}  // namespace firn
