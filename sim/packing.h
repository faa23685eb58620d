#pragma once
#include "sim/pack.h"
#include "sim/types.h"

namespace firn {

/// a^(1/n) of a > 0 for n = 1, 2, 3; 1 for n = 0.
template <class T> T root(T a, T n) {
    return select(n > T(2), cbrt(a), select(n > T(1), sqrt(a), select(n > T(0), a, T(1))));
}

/// The return mapping of snow that cannot be packed denser, so that its volume J [1] is elastic. The range of the
/// stretches shrinks as a whole, by the k ≤ 1 at which they have that volume:
///
///   σ_i = clamp(σ̂_i, k low, k high),   σ_0 σ_1 σ_2 = J,   for σ̂_0 σ̂_1 σ̂_2 ≤ J ≤ the product of clamp(σ̂_i, low, high)
///
/// Pressure is the elastic law's then, and shear has the bound it had: the largest over the smallest σ_i is at most high/low.
/// What lies in one of these ranges stays as it is, so that the mapping is idempotent; it is symmetric in the σ̂_i, so isotropic;
/// and since the ends are k = 1 and σ̂ itself, it is continuous in σ̂ and J_P. At constant volume it draws the ln σ_i
/// together, which for σ_i > ½ lowers Ψ. Scaling what was clamped, all alike, would make a fluid of compressed snow: the
/// next step would find all σ_i below `low` and clamp them to one number.
///
/// The product g(k) grows with k. Between the six k = σ̂_i/low, σ̂_i/high at which a clamp ends or begins it goes with kⁿ,
/// where n of the σ_i are clamped; the least of those with g ≥ J begins the piece that holds J.
template <class T> Vec3<T> clamp_to_volume(const Vec3<T>& s, T J, T low, T high) {
    const Vec3<T> from = s / low, to = s / high;         // of the k at which σ̂_i is in its range
    const auto clamped = [&](T k) {
        Vec3<T> c;
        for (int i = 0; i < 3; ++i) c(i) = select(from(i) < k, T(k * low), select(k < to(i), T(k * high), s(i)));
        return c;
    };
    const auto product = [](const Vec3<T>& c) { return c(0) * c(1) * c(2); };
    T k(1);
    for (int i = 0; i < 6; ++i) {
        const T at = i < 3 ? from(i) : to(i - 3);
        k = select((at < k) & !(product(clamped(at)) < J), at, k);
    }
    Vec3<T> c = clamped(k);
    T n(0);
    for (int i = 0; i < 3; ++i) n += select((from(i) < k) | !(to(i) < k), T(1), T(0));
    const T shrink = root(T(J / product(c)), n);
    for (int i = 0; i < 3; ++i) c(i) = select((from(i) < k) | !(to(i) < k), T(c(i) * shrink), c(i));
    return c;
}

}  // namespace firn
