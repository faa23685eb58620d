#pragma once
#include "sim/decomposition.h"

// Snow as an elasto-plastic solid: Stomakhin, Schroeder, Chai, Teran, Selle, "A material point method for
// snow simulation", SIGGRAPH 2013, and its technical report of January 2013 ("report").
//
// F = F_E F_P. The energy depends on F_E; the stiffness on how far F_P has compacted, J_P = det F_P.
// F_P enters through J_P alone, so J_P is all that a particle keeps of it.
//
//   F_E  Fe   elastic deformation gradient [1]        μ, λ  mu, lambda   hardened Lamé parameters [Pa]
//   R, S      F_E = R S, R a rotation, S symmetric    Ψ     energy per initial volume [J/m³]
//   J    J    det F_E [1]                             P     ∂Ψ/∂F_E [Pa]
//   cof F     J F⁻ᵀ = ∂J/∂F: a polynomial in F, so it needs no inverse

namespace firn {

/// Snow, as the paper's table 2 has it by default.
struct Snow {
    double E = 1.4e5;         ///< Young's modulus E₀ [Pa]. Higher: icy and stiff to integrate; lower: muddy.
    double nu = 0.2;          ///< Poisson's ratio ν [1].
    double xi = 10;           ///< hardening ξ [1]. Higher: brittle; lower: ductile.
    double theta_c = 2.5e-2;  ///< critical compression θ_c [1]. Larger: chunky and wet; smaller: powdery and dry.
    double theta_s = 7.5e-3;  ///< critical stretch θ_s [1]. As θ_c, for tension.
    double rho = 400;         ///< density at the start ρ₀ [kg/m³].
    double max_density = 917; ///< that of ice: what is packed denser hardens no further [kg/m³].
};

/// What the formulas need of a Snow. T: a number, or a pack of them with a particle in each lane.
template <class T> struct SnowModel {
    T mu0, lambda0;   ///< [Pa]
    T xi;             ///< [1]
    T low, high;      ///< 1 − θ_c and 1 + θ_s, the range of the elastic singular values.
    T Jp_min;         ///< ρ₀ / max_density, at most 1: J_P below it hardens as it does.
};

/// μ₀ = E₀ / (2 (1 + ν)),  λ₀ = E₀ ν / ((1 + ν)(1 − 2ν))
inline SnowModel<double> model(const Snow& s) {
    return {s.E / (2 * (1 + s.nu)), s.E * s.nu / ((1 + s.nu) * (1 - 2 * s.nu)), s.xi, 1 - s.theta_c, 1 + s.theta_s,
            std::fmin(1, s.rho / s.max_density)};
}

template <class T> struct Lame { T mu, lambda; };  // [Pa]

/// μ = μ₀ exp(ξ (1 − J_P)),  λ = λ₀ exp(ξ (1 − J_P)), with J_P no smaller than where snow is ice.
template <class T> Lame<T> hardened(const SnowModel<T>& s, T Jp) {
    const T factor = exp(s.xi * (T(1) - maximum(Jp, s.Jp_min)));
    return {s.mu0 * factor, s.lambda0 * factor};
}

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

/// The same of singular values:  Ψ = μ Σ (σ_i − 1)² + λ/2 (J − 1)²
template <class T> T energy_density(const Vec3<T>& s, const Lame<T>& k) {
    const T J = s(0) * s(1) * s(2);
    return k.mu * Vec3<T>(s - Vec3<T>::Ones()).squaredNorm() + k.lambda / T(2) * (J - T(1)) * (J - T(1));
}

/// P = ∂Ψ/∂F = 2μ (F − R) + λ (J − 1) cof F                                                  report, sec. 2
template <class T> Mat3<T> stress(const Elastic<T>& e, const Lame<T>& k) {
    return T(2) * k.mu * (e.F - e.R) + k.lambda * (e.J - T(1)) * e.cof;
}

/// [ω]ₓ: the matrix whose product with a is ω × a.
template <class T> Mat3<T> cross_matrix(const Vec3<T>& w) {
    Mat3<T> W;
    W << T(0), -w(2), w(1), w(2), T(0), -w(0), -w(1), w(0), T(0);
    return W;
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

/// P F_Eᵀ for F_E = U Σ Vᵀ: the Kirchhoff stress τ = U diag(2μ (s − 1) s + λ (J − 1) J) Uᵀ [Pa], so that
/// V⁰ τ = V⁰ P F_Eᵀ is what the force (2) needs of a particle. (σ = τ / J: J cancels there.)
template <class T> Mat3<T> kirchhoff_stress(const Mat3<T>& U, const Vec3<T>& s, const Lame<T>& k) {
    const T J = s(0) * s(1) * s(2);
    Vec3<T> t;
    for (int i = 0; i < 3; ++i) t(i) = T(2) * k.mu * (s(i) - T(1)) * s(i) + k.lambda * (J - T(1)) * J;
    return U * t.asDiagonal() * U.transpose();
}

/// A particle's elastic state after the return mapping.
template <class T> struct Returned {
    Mat3<T> Fe;
    T Jp;
    Mat3<T> tau;  ///< P F_Eᵀ at the hardened μ, λ [Pa].
    Lame<T> k;    ///< hardened by the new J_P.
    T energy_density;  ///< Ψ [J/m³]
};

/// Return mapping. F̂_E = U Σ̂ Vᵀ with U, V rotations:  Σ ← clamp(Σ̂, 1 − θ_c, 1 + θ_s),  F_E ← U Σ Vᵀ.
/// What is cut from F_E goes to F_P, so that J_E J_P stays what it was:  J_P ← J_P det F̂_E / det F_E.
/// F̂_E that needs no cut is kept to the bit.                                                 paper, sec. 7
template <class T> Returned<T> return_map(const SnowModel<T>& s, const Mat3<T>& Fe_trial, T Jp) {
    const Decomposition<T> d = decompose(Fe_trial);
    Vec3<T> sigma;
    for (int i = 0; i < 3; ++i) sigma(i) = clamp(d.s(i), s.low, s.high);
    const T cut = absolute(T(d.s(0) - sigma(0))) + absolute(T(d.s(1) - sigma(1))) + absolute(T(d.s(2) - sigma(2)));
    const auto plastic = cut > T(0);
    const Mat3<T> Fe = d.U * sigma.asDiagonal() * d.V.transpose();
    Returned<T> r;
    for (int i = 0; i < 9; ++i) r.Fe(i) = select(plastic, Fe(i), Fe_trial(i));
    r.Jp = select(plastic, T(Jp * (d.s(0) * d.s(1) * d.s(2)) / (sigma(0) * sigma(1) * sigma(2))), Jp);
    r.k = hardened(s, r.Jp);
    r.tau = kirchhoff_stress(d.U, sigma, r.k);
    r.energy_density = energy_density(sigma, r.k);
    return r;
}

}  // namespace firn
