#pragma once
#include "sim/packing.h"
#include "sim/stretch.h"

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
    static constexpr double endless = 1e9;  ///< a max_density that nothing reaches, the paper's.
    double max_density = 917; ///< that of ice: snow is packed no denser and hardens no further [kg/m³].
};

/// What the formulas need of a Snow. T: a number, or a pack of them with a particle in each lane.
template <class T> struct SnowModel {
    T mu0, lambda0;   ///< [Pa]
    T xi;             ///< [1]
    T low, high;      ///< 1 − θ_c and 1 + θ_s, the range of the elastic singular values.
    T Jp_min;         ///< ρ₀ / max_density, at most 1: no J_P falls below it, and what begins below hardens as it does.
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

/// Ψ = μ ‖F − R‖² + λ/2 (J − 1)² of singular values:  μ Σ (σ_i − 1)² + λ/2 (J − 1)²              report, sec. 2
template <class T> T energy_density(const Vec3<T>& s, const Lame<T>& k) {
    const T J = s(0) * s(1) * s(2);
    return k.mu * Vec3<T>(s - Vec3<T>::Ones()).squaredNorm() + k.lambda / T(2) * (J - T(1)) * (J - T(1));
}

/// J − 1 of Y = V − I, F = V R, without the loss of digits of det F − 1.
template <class T> T volume_strain(const Symmetric<T>& Y) { return Y.trace() + Y.second_invariant() + Y.determinant(); }

/// The same of Y = V − I:  Ψ = μ ‖Y‖² + λ/2 (J − 1)²
template <class T> T energy_density(const Symmetric<T>& Y, const Lame<T>& k) {
    const T j = volume_strain(Y);
    return k.mu * Y.squared_norm() + k.lambda / T(2) * j * j;
}

/// [ω]ₓ: the matrix whose product with a is ω × a.
template <class T> Mat3<T> cross_matrix(const Vec3<T>& w) {
    Mat3<T> W;
    W << T(0), -w(2), w(1), w(2), T(0), -w(0), -w(1), w(0), T(0);
    return W;
}

/// P F_Eᵀ for F_E = V R, Y = V − I: the Kirchhoff stress τ = 2μ (V² − V) + λ (J − 1) J I [Pa], so that V⁰ τ = V⁰ P F_Eᵀ
/// is what the force (2) needs of a particle. (σ = τ / J: J cancels there.)
template <class T> Symmetric<T> kirchhoff_stress(const Symmetric<T>& Y, const Lame<T>& k) {
    const T j = volume_strain(Y);
    return (Y + Y.squared()) * (T(2) * k.mu) + Symmetric<T>::identity() * (k.lambda * j * (j + T(1)));
}

/// ω of δR = [ω]ₓ R along δF = G F, F = V R. The skew part of G V = δV + V [ω]ₓ is G V − V Gᵀ = V [ω]ₓ + [ω]ₓ V, and that
/// is [(tr V · I − V) ω]ₓ: the report's 3×3 system for δR, in the frame of the world. `K` is (tr V · I − V)⁻¹, finite for
/// every F that is not inverted.                                                             report, sec. 2
template <class T> Vec3<T> rotation_differential(const Symmetric<T>& K, const Mat3<T>& GV) {
    return K * Vec3<T>(GV(2, 1) - GV(1, 2), GV(0, 2) - GV(2, 0), GV(1, 0) - GV(0, 1));
}

/// δP F_Eᵀ along δF = G F_E in the frame of the world, the report's A_p F_Eᵀ of (4): with F = V R, δR = [ω]ₓ R,
///
///   2μ (G V − [ω]ₓ) V + λ J ((2J − 1) tr G I − (J − 1) Gᵀ)
///
/// since δF Fᵀ = G V², δR Fᵀ = [ω]ₓ V, (cof F : δF) cof F Fᵀ = J² tr G I and δ(cof F) Fᵀ = J (tr G I − Gᵀ).
template <class T> struct KirchhoffDifferential {
    Symmetric<T> V, K;          ///< left stretch, (tr V · I − V)⁻¹
    T mu2, trace, transposed;   ///< 2μ, λ J (2J − 1), λ J (J − 1)

    KirchhoffDifferential() = default;
    KirchhoffDifferential(const Symmetric<T>& Y, const Lame<T>& k)
        : V(Y + Symmetric<T>::identity()), K((Symmetric<T>::identity() * V.trace() - V).inverse()), mu2(T(2) * k.mu) {
        const T j = volume_strain(Y);
        trace = k.lambda * (j + T(1)) * (j + j + T(1)), transposed = k.lambda * (j + T(1)) * j;
    }
    Mat3<T> operator()(const Mat3<T>& G) const {
        Mat3<T> A = G * V.matrix();
        A -= cross_matrix(rotation_differential(K, A));
        A = mu2 * (A * V.matrix()) - transposed * G.transpose();
        const T pressure = trace * G.trace();
        for (int i = 0; i < 3; ++i) A(i, i) += pressure;
        return A;
    }
};

/// A particle's elastic state after the return mapping.
template <class T> struct Returned {
    Mat3<T> Fe;
    T Jp;
    Symmetric<T> tau;   ///< P F_Eᵀ at the hardened μ, λ [Pa].
    Lame<T> k;          ///< hardened by the new J_P.
    T energy_density;   ///< Ψ [J/m³]
    T trial_density;    ///< Ψ of F̂_E at the μ, λ before [J/m³].
};

/// Return mapping. F̂_E = U Σ̂ Wᵀ with U, W rotations:  Σ ← clamp(Σ̂, 1 − θ_c, 1 + θ_s),  F_E ← U Σ Wᵀ = U (Σ/Σ̂) Uᵀ F̂_E.
/// What is cut from F_E goes to F_P, so that J_E J_P stays what it was:  J_P ← J_P det F̂_E / det F_E.
/// F̂_E that needs no cut is kept to the bit.                                                 paper, sec. 7
///
/// Where that J_P would be below L = min(J_P, J_P,min) (one below J_P,min from the start may grow only), snow is packed as
/// densely as it can be, and what is left of the compression is elastic (beyond the paper):
///
///   J_P ← L,  Σ ← clamp(Σ̂, k (1 − θ_c), k (1 + θ_s)) with the k < 1 at which det Σ = J_P det Σ̂ / L   ("sim/packing.h")
template <class T> Returned<T> return_map(const SnowModel<T>& s, const Mat3<T>& Fe_trial, T Jp) {
    using Scalar = typename ScalarOf<T>::type;
    const Symmetric<T> X = cauchy_green(Fe_trial), I = Symmetric<T>::identity();
    const T norm2 = X.squared_norm(), lowest = s.low * s.low - T(1), highest = s.high * s.high - T(1);
    const auto near = norm2 < T(Scalar(series_radius * series_radius));
    auto elastic = norm2 < minimum(T(lowest * lowest), T(highest * highest));
    if (any(!elastic)) elastic = elastic | (positive_definite(X - I * lowest) & positive_definite(I * highest - X));
    Returned<T> r;
    r.Fe = Fe_trial, r.Jp = Jp;
    Symmetric<T> Y = root_series(X);
    Vec3<T> stretch = Vec3<T>::Ones();
    if (any(!(elastic & near))) {
        const SingularSystem<T> l = singular_system(Fe_trial, X);
        Vec3<T> sigma, ratio;
        stretch = l.s;
        for (int i = 0; i < 3; ++i) sigma(i) = select(elastic, l.s(i), clamp(l.s(i), s.low, s.high));
        const T J_trial = l.s(0) * l.s(1) * l.s(2), least = minimum(Jp, s.Jp_min);
        r.Jp = select(elastic, Jp, T(Jp * J_trial / (sigma(0) * sigma(1) * sigma(2))));
        if (const auto packed = r.Jp < least; any(packed)) {
            const Vec3<T> dense = clamp_to_volume(l.s, T(J_trial * (Jp / least)), s.low, s.high);
            for (int i = 0; i < 3; ++i) sigma(i) = select(packed, dense(i), sigma(i));
            r.Jp = select(packed, least, r.Jp);
        }
        for (int i = 0; i < 3; ++i) ratio(i) = select(elastic, T(1), T(sigma(i) / l.s(i)));
        r.Fe += turned(l.U, Vec3<T>(ratio - Vec3<T>::Ones())).matrix() * Fe_trial;
        if (any(l.far)) {
            const Mat3<T> whole = l.U * sigma.asDiagonal() * l.W.transpose();
            for (int i = 0; i < 9; ++i) r.Fe(i) = select(l.far & !elastic, whole(i), r.Fe(i));
        }
        Y = select(elastic & near, Y, turned(l.U, Vec3<T>(sigma - Vec3<T>::Ones())));
    }
    r.k = hardened(s, r.Jp);
    r.tau = kirchhoff_stress(Y, r.k);
    r.energy_density = r.trial_density = energy_density(Y, r.k);
    if (any(!elastic)) r.trial_density = select(elastic, r.energy_density, energy_density(stretch, hardened(s, Jp)));
    return r;
}

}  // namespace firn
