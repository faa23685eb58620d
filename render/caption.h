#pragma once
#include "render/colour_map.h"
#include "render/image.h"

#include <string>
#include <vector>

namespace firn {

/// Writes lines of text into the upper left corner, in an embedded 5×7 font, as large as the picture allows.
/// ASCII letters, digits and the usual signs; anything else is a blank.
void draw_text(Image&, const std::vector<std::string>& lines);

/// Draws a colour map's scale along the right edge, with values at five even steps and its title.
void draw_legend(Image&, Colour, const ColourRange&);

}  // namespace firn
