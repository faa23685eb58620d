#pragma once
#include "sim/node_field.h"

namespace firn {

/// Friction at a node that slides, as a potential of its velocity, with s = `free` (v − a):
///
///   ψ = c ‖s‖ − c²/2D,  or D ‖s‖²/2 where ‖s‖ < c/D;      q = −∂ψ/∂v = −s min(D, c/‖s‖)
///
/// For a = v_co + r_t/D with the friction r_t that there was, q = r_t where Coulomb's law holds of r_t and v: they are
/// opposite and ‖r_t‖ = c, or v_t = 0. (The augmented Lagrangian of Alart and Curnier 1991.)
template <class Real> struct Friction {
    std::size_t node;
    Mat3<Real> free;
    Vec3<Real> a;           ///< [m/s]
    Real c;                 ///< μ times what presses, over the step [kg m/s].
    Real D;                 ///< [kg]
    Mat3<Real> stiffness = Mat3<Real>::Zero();  ///< ∂²ψ/∂v² where it was moved to last [kg].

    /// Moves to v: adds q to the node's `sum`. Returns ψ.
    double move(const NodeField<Real>& v, NodeField<Real>& sum) {
        const Vec3<Real> s = free * (vector_at(v) - a);
        const Real length = s.norm(), k = std::min(D, c / length);
        const bool slides = k < D;
        stiffness = k * free;
        if (slides) stiffness -= k / (length * length) * s * s.transpose();
        add(Vec3<Real>(-k * s), sum);
        return slides ? c * (length - c / (2 * D)) : D * length * length / 2;
    }
    /// Adds ∂²ψ/∂v² u times `factor`.
    void add_product(const NodeField<Real>& u, Real factor, NodeField<Real>& sum) const {
        add(Vec3<Real>(factor * stiffness * vector_at(u)), sum);
    }

private:
    Vec3<Real> vector_at(const NodeField<Real>& u) const { return {u.at[node][0], u.at[node][1], u.at[node][2]}; }
    void add(const Vec3<Real>& a_i, NodeField<Real>& sum) const {
        sum.at[node] += NodeVector<Real>::of(a_i(0), a_i(1), a_i(2), 0);
    }
};

}  // namespace firn
