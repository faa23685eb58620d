#include "render/compare.h"

#include "render/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace firn {

namespace {

void require_same_size(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height)
        throw std::invalid_argument("pictures of different sizes: " + std::to_string(a.width) + "×" +
                                    std::to_string(a.height) + " and " + std::to_string(b.width) + "×" +
                                    std::to_string(b.height));
}

/// Largest |a − b| of a pixel's channels, 0 to 1.
double pixel_error(const Image& a, const Image& b, std::size_t pixel) {
    int largest = 0;
    for (std::size_t c = 3 * pixel; c < 3 * pixel + 3; ++c)
        largest = std::max(largest, std::abs(int(a.pixels[c]) - int(b.pixels[c])));
    return largest / 255.0;
}

struct Plane2d {
    int width, height;
    std::vector<double> values;
};

/// Luma of Rec. 601, of the sRGB values, 0 to 1.
Plane2d luma(const Image& image) {
    Plane2d result{image.width, image.height, std::vector<double>(image.pixels.size() / 3)};
    for (std::size_t p = 0; p < result.values.size(); ++p)
        result.values[p] = (0.299 * image.pixels[3 * p] + 0.587 * image.pixels[3 * p + 1] +
                            0.114 * image.pixels[3 * p + 2]) /
                           255;
    return result;
}

Plane2d product(const Plane2d& a, const Plane2d& b) {
    Plane2d result = a;
    for (std::size_t i = 0; i < result.values.size(); ++i) result.values[i] *= b.values[i];
    return result;
}

std::vector<double> gaussian_window(int size) {
    constexpr double sigma = 1.5;
    std::vector<double> window;
    double sum = 0;
    for (int i = 0; i < size; ++i) {
        const double x = i - 0.5 * (size - 1);
        window.push_back(std::exp(-x * x / (2 * sigma * sigma)));
        sum += window.back();
    }
    for (double& w : window) w /= sum;
    return window;
}

/// Weighted mean of every window that lies wholly inside.
Plane2d window_means(const Plane2d& plane, const std::vector<double>& across,
                     const std::vector<double>& down) {
    const int width = plane.width - int(across.size()) + 1, height = plane.height - int(down.size()) + 1;
    Plane2d rows{width, plane.height, std::vector<double>(std::size_t(width) * plane.height)};
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x < width; ++x)
            for (std::size_t i = 0; i < across.size(); ++i)
                rows.values[std::size_t(y) * width + x] +=
                    across[i] * plane.values[std::size_t(y) * plane.width + x + i];
    Plane2d result{width, height, std::vector<double>(std::size_t(width) * height)};
    for (int y = 0; y < height; ++y)
        for (std::size_t j = 0; j < down.size(); ++j)
            for (int x = 0; x < width; ++x)
                result.values[std::size_t(y) * width + x] += down[j] * rows.values[(y + j) * width + x];
    return result;
}

/// Mean over all windows of  (2 μ_a μ_b + C₁)(2 σ_ab + C₂) / ((μ_a² + μ_b² + C₁)(σ_a² + σ_b² + C₂)).
double structural_similarity(const Image& image_a, const Image& image_b) {
    constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const std::vector<double> across = gaussian_window(std::min(11, image_a.width));
    const std::vector<double> down = gaussian_window(std::min(11, image_a.height));
    const Plane2d a = luma(image_a), b = luma(image_b);
    const Plane2d mean_a = window_means(a, across, down), mean_b = window_means(b, across, down);
    const Plane2d mean_aa = window_means(product(a, a), across, down);
    const Plane2d mean_bb = window_means(product(b, b), across, down);
    const Plane2d mean_ab = window_means(product(a, b), across, down);
    double sum = 0;
    for (std::size_t i = 0; i < mean_a.values.size(); ++i) {
        const double ma = mean_a.values[i], mb = mean_b.values[i];
        const double var_a = mean_aa.values[i] - ma * ma, var_b = mean_bb.values[i] - mb * mb;
        const double cov = mean_ab.values[i] - ma * mb;
        sum += (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (var_a + var_b + c2));
    }
    return sum / static_cast<double>(mean_a.values.size());
}

/// Black, purple, orange, yellow, white; brightness grows all the way.
std::array<std::uint8_t, 3> heat_colour(double t) {
    constexpr double stops[6][3] = {{0, 0, 0},      {60, 15, 110},  {150, 40, 120},
                                    {230, 100, 50}, {250, 200, 60}, {255, 255, 255}};
    const double at = 5 * std::clamp(t, 0.0, 1.0);
    const int below = std::min(int(at), 4);
    std::array<std::uint8_t, 3> colour;
    for (int c = 0; c < 3; ++c)
        colour[c] = static_cast<std::uint8_t>(
            std::lround(stops[below][c] + (at - below) * (stops[below + 1][c] - stops[below][c])));
    return colour;
}

}  // namespace

ImageDifference compare_images(const Image& a, const Image& b, double tolerance) {
    require_same_size(a, b);
    ImageDifference result;
    const std::size_t pixels = a.pixels.size() / 3;
    if (pixels == 0) return {0, 0, std::numeric_limits<double>::infinity(), 1, 0, 0};
    double sum = 0, squares = 0;
    for (std::size_t c = 0; c < a.pixels.size(); ++c) {
        const double error = std::abs(int(a.pixels[c]) - int(b.pixels[c])) / 255.0;
        sum += error, squares += error * error;
        result.max_error = std::max(result.max_error, error);
    }
    std::size_t above = 0;
    for (std::size_t p = 0; p < pixels; ++p) above += pixel_error(a, b, p) > tolerance;
    const auto values = static_cast<double>(a.pixels.size());
    result.mean_error = sum / values;
    result.psnr = squares > 0 ? 10 * std::log10(values / squares) : std::numeric_limits<double>::infinity();
    result.ssim = structural_similarity(a, b);
    result.flip = flip(a, b);
    result.share_above = static_cast<double>(above) / static_cast<double>(pixels);
    return result;
}

Image heat_map(const Image& a, const Image& b, double full_scale) {
    require_same_size(a, b);
    Image result{a.width, a.height, std::vector<std::uint8_t>(a.pixels.size())};
    for (std::size_t p = 0; p < a.pixels.size() / 3; ++p) {
        const auto colour =
            heat_colour(full_scale > 0 ? pixel_error(a, b, p) / full_scale : pixel_error(a, b, p) > 0);
        std::copy(colour.begin(), colour.end(), &result.pixels[3 * p]);
    }
    return result;
}

}  // namespace firn
