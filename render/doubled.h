#pragma once
#include "render/image.h"

namespace firn {

/// Twice as wide and high, or one pixel less where the size asks for it: three quarters of the nearest pixel and one of
/// the next, along both axes.
Image doubled(const Image&, int width, int height);

}  // namespace firn
