#pragma once
#include "sim/decomposition.h"
#include "sim/symmetric.h"

// Snow breaks before it is strained by much: nearly always F Fᵀ is close to I. There the left stretch V = √(F Fᵀ) of
// F = V R, which is all that energy and force need, comes from a short series, and a test of two determinants tells
// whether any singular value is out of its range. Singular vectors are calculated only where one is.

namespace firn {

/// F Fᵀ − I
template <class T> Symmetric<T> cauchy_green(const Mat3<T>& F) {
    const auto product = [&](int i, int j) {
        return T(F(i, 0) * F(j, 0) - T(i == j ? 1 : 0) + F(i, 1) * F(j, 1) + F(i, 2) * F(j, 2));
    };
    return {product(0, 0), product(0, 1), product(0, 2), product(1, 1), product(1, 2), product(2, 2)};
}

constexpr double series_radius = 0.1;   ///< ‖X‖ up to which `root_series` is good to round-off.

/// √(I + X) − I = Σ_n c_n Xⁿ,  c₁ = ½,  c_{n+1} = c_n (½ − n)/(n + 1), for ‖X‖ ≤ 0.1: what is left out is below
/// c_{N+1} 0.1^(N+1)/0.9 = 2e-9 (float, N = 6) or 6e-18 (double, N = 14). Cayley and Hamilton, X³ = i₁ X² − i₂ X + i₃,
/// keep Horner's sum a polynomial a + b X + c X².
template <class T> Symmetric<T> root_series(const Symmetric<T>& X) {
    using Scalar = typename ScalarOf<T>::type;
    constexpr int terms = sizeof(Scalar) == 4 ? 6 : 14;
    const T i1 = X.trace(), i2 = X.second_invariant(), i3 = X.determinant();
    double coefficient[terms + 1] = {0, 0.5};
    for (int n = 1; n < terms; ++n) coefficient[n + 1] = coefficient[n] * (0.5 - n) / (n + 1);
    T a = T(Scalar(coefficient[terms])), b(0), c(0);
    for (int n = terms - 1; n >= 0; --n) {
        const T next_a = T(Scalar(coefficient[n])) + c * i3, next_b = a - c * i2, next_c = b + c * i1;
        a = next_a, b = next_b, c = next_c;
    }
    return Symmetric<T>::identity() * a + X * b + X.squared() * c;
}

/// F = U Σ Wᵀ, W only where F is far from a rotation.
template <class T> struct SingularSystem {
    Mat3<T> U, W;
    Vec3<T> s;
    decltype(T() < T()) far;
};

/// From the eigensystem of X = F Fᵀ − I where that loses no digits that matter, elsewhere from F itself.
template <class T> SingularSystem<T> singular_system(const Mat3<T>& F, const Symmetric<T>& X) {
    using Scalar = typename ScalarOf<T>::type;
    const auto far = !(X.squared_norm() < T(Scalar(0.25)));
    const Eigensystem<T> e = eigensystem(select(far, Symmetric<T>::identity() * T(0), X));
    SingularSystem<T> r{e.Q, Mat3<T>::Identity(), {}, far};
    for (int i = 0; i < 3; ++i) r.s(i) = sqrt(T(T(1) + e.x(i)));
    if (any(far)) {
        const Decomposition<T> d = decompose(F);
        r.W = d.V;
        for (int i = 0; i < 9; ++i) r.U(i) = select(far, d.U(i), r.U(i));
        for (int i = 0; i < 3; ++i) r.s(i) = select(far, d.s(i), r.s(i));
    }
    return r;
}

/// V − I of F = V R, V = √(F Fᵀ). For det F < 0 with the smallest singular value negative, as `decompose` has it.
template <class T> Symmetric<T> left_strain(const Mat3<T>& F) {
    using Scalar = typename ScalarOf<T>::type;
    const Symmetric<T> X = cauchy_green(F);
    const auto far = !(X.squared_norm() < T(Scalar(series_radius * series_radius)));
    const Symmetric<T> Y = root_series(X);
    if (!any(far)) return Y;
    const SingularSystem<T> l = singular_system(F, X);
    return select(far, turned(l.U, Vec3<T>(l.s - Vec3<T>::Ones())), Y);
}

}  // namespace firn
