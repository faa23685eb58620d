#pragma once
#include "sim/snow.h"

namespace firn {

// In the basis of F = U Σ Vᵀ the second derivative of Ψ(σ₀, σ₁, σ₂) falls apart (Stomakhin, Howes, Schroeder, Teran
// 2012; report, sec. 2, says it as a δR):  δF̂ = Uᵀ δF V → δP̂ = Uᵀ δP V
//
//   diagonal          δP̂_ii = Σ_j A_ij δF̂_jj,            A_ij = ∂²Ψ/∂σ_i∂σ_j
//   each pair i < j   even (δF̂_ij + δF̂_ji):             (Ψ_i − Ψ_j)/(σ_i − σ_j) = 2μ − λ (J − 1) σ_k
//                     odd  (δF̂_ij − δF̂_ji):             (Ψ_i + Ψ_j)/(σ_i + σ_j) = 2μ (1 − 2/(σ_i + σ_j)) + λ (J − 1) σ_k
//
// Positive semi-definite where each piece is: negative eigenvalues are cut.

/// Ψ_i = ∂Ψ/∂σ_i = 2μ (σ_i − 1) + λ (J − 1) σ_j σ_k: the diagonal of P̂ = Uᵀ P V.
template <class T> Vec3<T> principal_stress(const Vec3<T>& s, const Lame<T>& k) {
    const Vec3<T> cof(s(1) * s(2), s(2) * s(0), s(0) * s(1));
    const T J = s(0) * cof(0);
    return T(2) * k.mu * (s - Vec3<T>::Ones()) + k.lambda * (J - T(1)) * cof;
}

/// The eigenvalues of Ψ's second derivative, in its pieces.
template <class T> struct HessianPieces {
    Mat3<T> A;
    Vec3<T> even, odd;  ///< of the pairs (1, 2), (2, 0), (0, 1), so that k is the index.
};

template <class T> HessianPieces<T> hessian_pieces(const Vec3<T>& s, const Lame<T>& k) {
    using Scalar = typename ScalarOf<T>::type;
    const T J = s(0) * s(1) * s(2);
    HessianPieces<T> p;
    for (int i = 0; i < 3; ++i) {
        const T cof = s((i + 1) % 3) * s((i + 2) % 3);
        p.A(i, i) = T(2) * k.mu + k.lambda * cof * cof;
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        p.A(a, b) = p.A(b, a) = k.lambda * (T(2) * J - T(1)) * s(i);
        const T pressure = k.lambda * (J - T(1)) * s(i);
        const T sum = maximum(T(s(a) + s(b)), T(std::numeric_limits<Scalar>::epsilon()));
        p.even(i) = T(2) * k.mu - pressure;
        p.odd(i) = T(2) * k.mu * (T(1) - T(2) / sum) + pressure;
    }
    return p;
}

/// The nearest positive semi-definite ones. For symmetric A = Q Λ Qᵀ that is (A + Q |Λ| Qᵀ)/2, and Q |Λ| Qᵀ the
/// symmetric factor of A's polar decomposition.
template <class T> HessianPieces<T> projected(const HessianPieces<T>& p) {
    const Decomposition<T> d = decompose(p.A);
    Vec3<T> s = d.s;
    s(2) = absolute(s(2));
    HessianPieces<T> r;
    r.A = (p.A + d.V * s.asDiagonal() * d.V.transpose()) / T(2);
    for (int i = 0; i < 3; ++i) r.even(i) = maximum(p.even(i), T(0)), r.odd(i) = maximum(p.odd(i), T(0));
    return r;
}

/// V_p⁰ A_p F_Eᵀ as a function of ∇u, as StressDifferential is, at F = U Σ Vᵀ other than F_E, and projected.
template <class P> struct ProjectedDifferential {
    Mat3<P> U, W;           ///< W = F_E V
    HessianPieces<P> pieces;

    ProjectedDifferential() = default;
    ProjectedDifferential(const Decomposition<P>& d, const Mat3<P>& Fe, const Lame<P>& k)
        : U(d.U), W(Fe * d.V), pieces(projected(hessian_pieces(d.s, k))) {}

    Mat3<P> operator()(const Mat3<P>& gradient) const {
        const Mat3<P> dF = U.transpose() * gradient * W;
        Mat3<P> dP;
        for (int k = 0; k < 3; ++k) {
            const int i = (k + 1) % 3, j = (k + 2) % 3;
            const P even = pieces.even(k) * (dF(i, j) + dF(j, i)) / P(2), odd = pieces.odd(k) * (dF(i, j) - dF(j, i)) / P(2);
            dP(i, j) = even + odd, dP(j, i) = even - odd;
            dP(k, k) = pieces.A(k, 0) * dF(0, 0) + pieces.A(k, 1) * dF(1, 1) + pieces.A(k, 2) * dF(2, 2);
        }
        return U * dP * W.transpose();
    }
};

}  // namespace firn
