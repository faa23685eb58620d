#pragma once
#include "render/image.h"

namespace firn {

/// How far apart two pictures of one size are; channel values count from 0 to 1.
struct ImageDifference {
    double mean_error = 0;  ///< mean |a − b| over all channels.
    double max_error = 0;   ///< largest |a − b|.
    double psnr = 0;        ///< 10 log₁₀(1 / mean (a − b)²) [dB]; infinite for equal pictures.
    double ssim = 1;  ///< mean structural similarity of luma, 11×11 Gaussian window (Wang et al. 2004).
    double flip = 0;  ///< mean ꟻLIP, what an eye sees of the difference, 0 to 1 (Andersson et al. 2020).
    double share_above = 0;  ///< share of pixels with a channel that differs by more than the tolerance.
};

/// Throws std::invalid_argument where the sizes differ.
ImageDifference compare_images(const Image& a, const Image& b, double tolerance);

/// Largest channel difference of every pixel, as colours from black (none) to white (`full_scale` or more).
Image heat_map(const Image& a, const Image& b, double full_scale);

}  // namespace firn
