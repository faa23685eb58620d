#pragma once
#include "render/image.h"

#include <vector>

namespace firn {

/// ꟻLIP [Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild: "FLIP: a difference evaluator for
/// alternating images", 2020], the form for pictures of 8 bits: of every pixel, from 0 to 1, how much an eye
/// sees of the difference when one picture takes the other's place.
/// `pixels_per_degree`: the authors' 67.02 is a screen 0.7 m wide with 3840 pixels, 0.7 m away.
std::vector<float> flip_map(const Image& a, const Image& b, double pixels_per_degree = 67.0206);

/// Mean of the map.
double flip(const Image& a, const Image& b);

}  // namespace firn
