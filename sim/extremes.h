#pragma once
#include <algorithm>

namespace firn {

/// Largest values over particles after a step, which bound the next Δt, and their energy.
struct Extremes {
    double speed = 0;        ///< |v_p| [m/s]
    double wave = 0;         ///< speed of sound √((λ + 2μ) V⁰ / m), hardened [m/s]
    double strain_rate = 0;  ///< ‖∇v_p‖ [1/s]
    double bulk_rate = 0;    ///< ‖∇v_p‖ that all but a thousandth of the mass stays below (loose snow counts less) [1/s]; of all particles together only.
    double kinetic = 0;      ///< Σ ½ m v² [J]
    double elastic = 0;      ///< Σ V⁰ Ψ [J]
    double height = 0;       ///< Σ m g·x [J]: what gravity has given.
    double energy() const { return kinetic + elastic; }
    void include(const Extremes& e) {
        speed = std::max(speed, e.speed), wave = std::max(wave, e.wave),
        strain_rate = std::max(strain_rate, e.strain_rate);
        kinetic += e.kinetic, elastic += e.elastic, height += e.height;
    }
};

}  // namespace firn
