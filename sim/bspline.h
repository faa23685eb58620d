#pragma once
#include "sim/settings.h"

#include <cmath>

namespace firn {

/// The B-spline of either degree. A particle reaches `width` nodes along each axis, from its base node on.
///   cubic:     N(d) = |d|³/2 − d² + 2/3 for |d| < 1;  −|d|³/6 + d² − 2|d| + 4/3 for |d| < 2
///   quadratic: N(d) = 3/4 − d² for |d| < 1/2;  (3/2 − |d|)²/2 for |d| < 3/2
template <Weights kind> struct BSpline {
    static constexpr int width = kind == Weights::cubic ? 4 : 3;

    /// D of Σ_i w_ip (x_i − x_p)(x_i − x_p)ᵀ = D h² I [1].
    static constexpr double second_moment = kind == Weights::cubic ? 1.0 / 3 : 1.0 / 4;

    /// Base node of a particle at X = x/h.
    template <class Real> static Real base(Real X) {
        return kind == Weights::cubic ? std::floor(X) - 1 : std::floor(X - Real(0.5));
    }

    /// N and dN/dX at t = X − base, for the nodes base, base + 1, …
    /// Cubic: 1 ≤ t < 2. Quadratic: ½ ≤ t < 3/2.
    template <class T> static void evaluate(T t, T (&N)[width], T (&dN)[width]) {
        if constexpr (kind == Weights::cubic) {
            const T a = t - T(1), b = T(1) - a;  // distances to the two middle nodes
            N[0] = b * b * b / T(6), dN[0] = -b * b / T(2);
            N[1] = a * a * (a / T(2) - T(1)) + T(2.0 / 3), dN[1] = a * (T(1.5) * a - T(2));
            N[2] = b * b * (b / T(2) - T(1)) + T(2.0 / 3), dN[2] = -b * (T(1.5) * b - T(2));
            N[3] = a * a * a / T(6), dN[3] = a * a / T(2);
        } else {
            const T a = T(1.5) - t, b = t - T(1), c = t - T(0.5);
            N[0] = a * a / T(2), dN[0] = -a;
            N[1] = T(0.75) - b * b, dN[1] = T(-2) * b;
            N[2] = c * c / T(2), dN[2] = c;
        }
    }
};

/// Weights of one particle along each axis; w_ip and ∇w_ip are products of them over the axes.
template <class Real, Weights kind> struct Stencil {
    static constexpr int width = BSpline<kind>::width;
    Vec3i base;             ///< first node.
    Real t[3];              ///< x/h − base [1].
    Real N[3][width];       ///< [1]
    Real dN[3][width];      ///< dN/dx [1/m].

    Stencil(const Vec3<Real>& x, Real h) {
        const Real per_h = 1 / h;
        for (int a = 0; a < 3; ++a) {
            // A true division: a product with 1/h could be contracted differently from place to place, and a
            // particle on the border would then have two base nodes.
            const Real X = x(a) / h, b = BSpline<kind>::base(X);
            base(a) = static_cast<int>(b);
            t[a] = X - b;
            BSpline<kind>::evaluate(t[a], N[a], dN[a]);
            for (Real& d : dN[a]) d *= per_h;
        }
    }
};

}  // namespace firn
