#pragma once

#include "render/image.h"

namespace firn {

/// A picture of this many pixels, each between its four nearest samples, of which `edge` < 1 lie along its edge; the
/// two have the same middle.
Image enlarged(const Image& samples, int width, int height, double edge);

}  // namespace firn
