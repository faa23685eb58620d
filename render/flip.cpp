#include "render/flip.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace firn {

namespace {

using Eigen::Vector3d;
constexpr double pi = std::numbers::pi;

/// One number a pixel, row by row.
struct Plane2f {
    int width, height;
    std::vector<float> values;
};
using Planes = std::array<Plane2f, 3>;

const Eigen::Matrix3d xyz_of_linear{{10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
                                    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
                                    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};
const Vector3d white = xyz_of_linear * Vector3d::Ones();

double linear_of(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

/// Opponent colours, linear in light: Y 116 − 16, C_x 500 (X − Y), C_z 200 (Y − Z), each over white's.
Vector3d opponent_of(const Vector3d& linear) {
    const Vector3d n = (xyz_of_linear * linear).cwiseQuotient(white);
    return {116 * n.y() - 16, 500 * (n.x() - n.y()), 200 * (n.y() - n.z())};
}

Vector3d linear_of_opponent(const Vector3d& c) {
    const double y = (c[0] + 16) / 116;
    static const Eigen::Matrix3d inverse = xyz_of_linear.inverse();
    return inverse * Vector3d(y + c[1] / 500, y, y - c[2] / 200).cwiseProduct(white);
}

/// CIELAB, its a and b weakened in the dark as eyes do [Hunt].
Vector3d hunt_lab_of(const Vector3d& linear) {
    const Vector3d n = (xyz_of_linear * linear).cwiseQuotient(white);
    const auto f = [](double t) {
        constexpr double d = 6.0 / 29;
        return t > d * d * d ? std::cbrt(t) : t / (3 * d * d) + 4.0 / 29;
    };
    const double L = 116 * f(n.y()) - 16;
    return {L, 0.01 * L * 500 * (f(n.x()) - f(n.y())), 0.01 * L * 200 * (f(n.y()) - f(n.z()))};
}

double hyab(const Vector3d& a, const Vector3d& b) {
    const Vector3d d = a - b;
    return std::abs(d[0]) + std::hypot(d[1], d[2]);
}

/// Along rows, then along columns; outside a picture its border goes on.
Plane2f convolved(const Plane2f& plane, const std::vector<double>& across, const std::vector<double>& down) {
    const int w = plane.width, h = plane.height;
    Plane2f rows{w, h, std::vector<float>(plane.values.size())}, result = rows;
    const auto pass = [&](const Plane2f& from, Plane2f& to, const std::vector<double>& kernel, bool along_x) {
        const int radius = static_cast<int>(kernel.size() / 2);
#pragma omp parallel for
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x) {
                double sum = 0;
                for (int i = -radius; i <= radius; ++i) {
                    const int xi = along_x ? std::clamp(x + i, 0, w - 1) : x;
                    const int yi = along_x ? y : std::clamp(y + i, 0, h - 1);
                    sum += kernel[i + radius] * from.values[std::size_t(yi) * w + xi];
                }
                to.values[std::size_t(y) * w + x] = static_cast<float>(sum);
            }
    };
    pass(plane, rows, across, true);
    pass(rows, result, down, false);
    return result;
}

/// What the eye still resolves of a channel: a sum of Gaussians a √(π/b) exp(−π² d²/b), d in degrees.
Plane2f seen(const Plane2f& plane, const std::vector<std::array<double, 2>>& terms, double ppd) {
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
    std::vector<std::vector<double>> kernels;
    std::vector<double> weights;
    double total = 0;
    for (const auto& [a, b] : terms) {
        std::vector<double> kernel;
        double sum = 0;
        for (int i = -radius; i <= radius; ++i) {
            kernel.push_back(std::exp(-pi * pi * (i / ppd) * (i / ppd) / b));
            sum += kernel.back();
        }
        for (double& k : kernel) k /= sum;
        kernels.push_back(kernel);
        weights.push_back(a * std::sqrt(pi / b) * sum * sum);
        total += weights.back();
    }
    Plane2f result{plane.width, plane.height, std::vector<float>(plane.values.size(), 0.0f)};
    for (std::size_t t = 0; t < terms.size(); ++t) {
        const Plane2f part = convolved(plane, kernels[t], kernels[t]);
        for (std::size_t p = 0; p < part.values.size(); ++p)
            result.values[p] += static_cast<float>(weights[t] / total) * part.values[p];
    }
    return result;
}

Planes opponent_planes(const Image& image) {
    Planes planes;
    planes.fill({image.width, image.height, std::vector<float>(image.pixels.size() / 3)});
    for (std::size_t p = 0; p < image.pixels.size() / 3; ++p) {
        Vector3d linear;
        for (int c = 0; c < 3; ++c) linear[c] = linear_of(image.pixels[3 * p + c] / 255.0);
        const Vector3d opponent = opponent_of(linear);
        for (int c = 0; c < 3; ++c) planes[c].values[p] = static_cast<float>(opponent[c]);
    }
    return planes;
}

/// Of every pixel, the colour that the eye sees, in Hunt's CIELAB.
std::vector<Vector3d> seen_colours(const Planes& planes, double ppd) {
    const Planes blurred = {seen(planes[0], {{1, 0.0047}}, ppd), seen(planes[1], {{1, 0.0053}}, ppd),
                            seen(planes[2], {{34.1, 0.04}, {13.5, 0.025}}, ppd)};
    std::vector<Vector3d> result(planes[0].values.size());
    for (std::size_t p = 0; p < result.size(); ++p) {
        const Vector3d opponent(blurred[0].values[p], blurred[1].values[p], blurred[2].values[p]);
        result[p] = hunt_lab_of(linear_of_opponent(opponent).cwiseMax(0.0).cwiseMin(1.0));
    }
    return result;
}

/// Strength of edges and of points in a picture's brightness: first and second derivatives of a Gaussian, the
/// positive and the negative weights of each adding up to one.
struct Features {
    std::vector<float> edges, points;
};

Features features_of(const Plane2f& lightness, double ppd) {
    const double deviation = 0.5 * 0.082 * ppd;
    const int radius = static_cast<int>(std::ceil(3 * deviation));
    std::vector<double> blur, edge, point;
    for (int i = -radius; i <= radius; ++i) {
        const double g = std::exp(-i * i / (2 * deviation * deviation));
        blur.push_back(g), edge.push_back(-i * g), point.push_back((i * i / (deviation * deviation) - 1) * g);
    }
    for (auto* kernel : {&blur, &edge, &point}) {
        double positive = 0, negative = 0;
        for (const double k : *kernel) (k > 0 ? positive : negative) += std::abs(k);
        for (double& k : *kernel) k /= k > 0 ? positive : negative > 0 ? negative : 1;
    }
    Plane2f unit = lightness;
    for (float& v : unit.values) v = (v + 16) / 116;
    const auto strength = [&](const std::vector<double>& kernel) {
        const Plane2f x = convolved(unit, kernel, blur), y = convolved(unit, blur, kernel);
        std::vector<float> result(x.values.size());
        for (std::size_t p = 0; p < result.size(); ++p) result[p] = std::hypot(x.values[p], y.values[p]);
        return result;
    };
    return {strength(edge), strength(point)};
}

}  // namespace

std::vector<float> flip_map(const Image& a, const Image& b, double ppd) {
    if (a.width != b.width || a.height != b.height)
        throw std::invalid_argument("pictures of different sizes have no ꟻLIP");
    const Planes planes_a = opponent_planes(a), planes_b = opponent_planes(b);
    const auto colours_a = seen_colours(planes_a, ppd), colours_b = seen_colours(planes_b, ppd);
    const Features features_a = features_of(planes_a[0], ppd), features_b = features_of(planes_b[0], ppd);

    constexpr double power = 0.7, knee = 0.4, at_knee = 0.95;
    const double most = std::pow(hyab(hunt_lab_of({0, 1, 0}), hunt_lab_of({0, 0, 1})), power);
    std::vector<float> map(colours_a.size());
    for (std::size_t p = 0; p < map.size(); ++p) {
        const double difference = std::pow(hyab(colours_a[p], colours_b[p]), power);
        const double colour = difference < knee * most ? at_knee / (knee * most) * difference
                                                       : at_knee + (difference - knee * most) /
                                                                       (most - knee * most) * (1 - at_knee);
        const double edge = std::abs(features_a.edges[p] - features_b.edges[p]);
        const double point = std::abs(features_a.points[p] - features_b.points[p]);
        const double feature = std::sqrt(std::max(edge, point) / std::numbers::sqrt2);
        map[p] = static_cast<float>(std::pow(colour, 1 - feature));
    }
    return map;
}

double flip(const Image& a, const Image& b) {
    double sum = 0;
    const std::vector<float> map = flip_map(a, b);
    for (const float v : map) sum += v;
    return map.empty() ? 0 : sum / static_cast<double>(map.size());
}

}  // namespace firn
