#pragma once
#include "sim/snow.h"

// Ψ and its derivatives as section 2 of the report prints them, on 3×3 matrices and as slow as that is. What the program
// computes in the frame of the world (sim/snow.h) is held against them.

namespace firn {

/// What Ψ, P and δP share, once for each F_E.
template <class T> struct Elastic {
    Mat3<T> F, R, S, cof;
    T J;
};

template <class T> Elastic<T> elastic(const Mat3<T>& Fe) {
    const Decomposition<T> d = decompose(Fe);
    return {Fe, d.rotation(), d.V * d.s.asDiagonal() * d.V.transpose(), cofactor(Fe), determinant(Fe)};
}

/// Ψ = μ ‖F − R‖² + λ/2 (J − 1)²                                                             report, sec. 2
template <class T> T energy_density(const Elastic<T>& e, const Lame<T>& k) {
    return k.mu * Mat3<T>(e.F - e.R).squaredNorm() + k.lambda / T(2) * (e.J - T(1)) * (e.J - T(1));
}

/// P = ∂Ψ/∂F = 2μ (F − R) + λ (J − 1) cof F                                                  report, sec. 2
template <class T> Mat3<T> stress(const Elastic<T>& e, const Lame<T>& k) {
    return T(2) * k.mu * (e.F - e.R) + k.lambda * (e.J - T(1)) * e.cof;
}

/// (tr S · I − S)⁻¹, the inverse of the report's 3×3 system for δR. Its eigenvalues are the pairwise sums of
/// F's singular values: finite for every F that is not inverted.
template <class T> Mat3<T> rotation_system_inverse(const Mat3<T>& S) {
    const Mat3<T> K = S.trace() * Mat3<T>::Identity() - S;
    const Mat3<T> C = cofactor(K);
    return C / K.col(0).dot(C.col(0));  // symmetric, so no transpose
}

/// δR from Rᵀ δF − δFᵀ R = (Rᵀ δR) S + S (Rᵀ δR). Both sides are skew; with Rᵀ δR = [ω]ₓ the right one is
/// [(tr S · I − S) ω]ₓ.                                                                      report, sec. 2
template <class T> Mat3<T> rotation_differential(const Mat3<T>& R, const Mat3<T>& K_inverse, const Mat3<T>& dF) {
    const Mat3<T> RtdF = R.transpose() * dF;
    const Vec3<T> axial(RtdF(2, 1) - RtdF(1, 2), RtdF(0, 2) - RtdF(2, 0), RtdF(1, 0) - RtdF(0, 1));
    return R * cross_matrix(Vec3<T>(K_inverse * axial));
}

/// δ(cof F) along δF, by the product rule on its columns.
template <class T> Mat3<T> cofactor_differential(const Mat3<T>& F, const Mat3<T>& dF) {
    Mat3<T> C;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        C.col(i) = dF.col(j).cross(F.col(k)) + F.col(j).cross(dF.col(k));
    }
    return C;
}

/// δP = 2μ (δF − δR) + λ (cof F : δF) cof F + λ (J − 1) δ(cof F)                             report, sec. 2
template <class T> Mat3<T> stress_differential(const Mat3<T>& F, const Mat3<T>& dR, const Lame<T>& k, const Mat3<T>& dF) {
    const Mat3<T> cof = cofactor(F);
    const T J = F.col(0).dot(cof.col(0));
    const T dJ = cof.cwiseProduct(dF).sum();
    return T(2) * k.mu * (dF - dR) + k.lambda * dJ * cof + k.lambda * (J - T(1)) * cofactor_differential(F, dF);
}
template <class T> Mat3<T> stress_differential(const Elastic<T>& e, const Lame<T>& k, const Mat3<T>& dF) {
    return stress_differential(e.F, rotation_differential(e.R, rotation_system_inverse(e.S), dF), k, dF);
}

}  // namespace firn
