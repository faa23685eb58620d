#pragma once
#include "sim/pack.h"
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

    /// Where the particles of a block are in the middle [cells from the block's first node].
    static constexpr double center = kind == Weights::cubic ? 3 : 2.5;

    /// Base node of a particle at X = x/h. T: a number or a pack.
    template <class T> static T base(T X) {
        return kind == Weights::cubic ? T(floor(X) - T(1)) : T(floor(X - T(0.5)));
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

/// Where particles at x are on the grid. T: a number or a pack.
template <Weights kind, class T> struct Place {
    Vec3<T> base;           ///< first node, an integer.
    Vec3<T> t;              ///< x/h − base [1].

    /// A true division: a product with 1/h could be contracted differently from place to place, and a particle on
    /// the border would then have two base nodes.
    Place(const Vec3<T>& x, T h) {
        for (int a = 0; a < 3; ++a) {
            const T X = x(a) / h;
            base(a) = BSpline<kind>::base(X);
            t(a) = X - base(a);
        }
    }
};

/// Weights of a group's particles along each axis; w_ip and ∇w_ip are products of them over the axes.
template <class Real, Weights kind> struct Stencils {
    using P = Pack<Real, lanes>;
    static constexpr int width = BSpline<kind>::width;
    P N[3][width];          ///< [1]
    P dN[3][width];         ///< dN/dx [1/m]

    Stencils() = default;
    Stencils(const Vec3<P>& t, Real h) {
        for (int a = 0; a < 3; ++a) {
            BSpline<kind>::evaluate(t(a), N[a], dN[a]);
            for (P& d : dN[a]) d *= P(1 / h);
        }
    }
};

}  // namespace firn
