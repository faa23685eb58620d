#pragma once
#include "render/colour_map.h"
#include "render/image.h"

#include <string>
#include <vector>

namespace firn {

/// Writes lines of text into the upper left corner, in stb_easy_font's letters, as large as the picture allows;
/// what they lack as printable() puts it.
void draw_text(Image&, const std::vector<std::string>& lines);

/// Draws a colour map's scale along the right edge, with values at five even steps and its title.
void draw_legend(Image&, Colour, const ColourRange&);

}  // namespace firn
