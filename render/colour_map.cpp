#include "render/colour_map.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace firn {

namespace {

using Rgb = std::array<std::uint8_t, 3>;

/// Viridis of matplotlib (S. van der Walt and N. Smith, CC0), at every ninth.
constexpr Rgb viridis[] = {{68, 1, 84},    {72, 40, 120},  {62, 73, 137},  {49, 104, 142}, {38, 130, 142},
                           {31, 158, 137}, {53, 183, 121}, {110, 206, 88}, {181, 222, 43}, {253, 231, 37}};

/// Cool to warm, K. Moreland, "Diverging color maps for scientific visualization", 2009, at every eighth.
constexpr Rgb cool_warm[] = {{59, 76, 192},   {98, 130, 234},  {141, 176, 254},
                             {184, 208, 249}, {221, 221, 221}, {245, 196, 173},
                             {244, 154, 123}, {222, 96, 77},   {180, 4, 38}};

}  // namespace

Rgb mapped_colour(Colour colour, double share) {
    const std::span<const Rgb> stops =
        colour == Colour::compression ? std::span<const Rgb>(cool_warm) : std::span<const Rgb>(viridis);
    const double at = (std::isfinite(share) ? std::clamp(share, 0.0, 1.0) : 0.0) * double(stops.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), stops.size() - 2);
    Rgb result;
    for (int c = 0; c < 3; ++c)
        result[c] = static_cast<std::uint8_t>(
            std::lround(stops[below][c] + (at - double(below)) * (stops[below + 1][c] - stops[below][c])));
    return result;
}

std::string colour_title(Colour colour) {
    switch (colour) {
        case Colour::speed: return "speed [m/s]";
        case Colour::density: return "density [kg/m3]";
        case Colour::compression: return "J_P [1]";
        case Colour::stress: return "von Mises stress [Pa]";
        case Colour::body: return "body";
        case Colour::particle_id: return "particle";
        case Colour::sleeping: return "awake (0), asleep (1)";
        case Colour::snow: break;
    }
    return "";
}

double ColourRange::share(double value) const { return high > low ? (value - low) / (high - low) : 0.5; }

}  // namespace firn
