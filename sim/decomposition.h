#pragma once
#include "sim/pack.h"
#include "sim/types.h"

namespace firn {

/// F = U Σ Vᵀ with **rotations** U, V (det +1). s₀ ≥ s₁ ≥ |s₂|: where det F < 0 the smallest singular value
/// carries the sign, so that U Vᵀ is the rotation nearest to F.
template <class T> struct Decomposition {
    Mat3<T> U, V;
    Vec3<T> s;
    Mat3<T> rotation() const { return U * V.transpose(); }
};

/// cof F = ∂(det F)/∂F = J F⁻ᵀ. Columns: f₁×f₂, f₂×f₀, f₀×f₁.
template <class T> Mat3<T> cofactor(const Mat3<T>& F) {
    Mat3<T> C;
    C.col(0) = F.col(1).cross(F.col(2));
    C.col(1) = F.col(2).cross(F.col(0));
    C.col(2) = F.col(0).cross(F.col(1));
    return C;
}

template <class T> T determinant(const Mat3<T>& F) { return F.col(0).dot(F.col(1).cross(F.col(2))); }

/// One-sided Jacobi (Hestenes 1958): turns pairs of columns of B = F V until all three are orthogonal.
/// Never forms FᵀF, so small singular values keep their digits. For finite F: orthogonality and
/// reconstruction to a few ulp of ‖F‖; F = 0 gives Σ = 0. NaN in, NaN out.
/// T: float, double, or a pack of eight of them; a lane's result does not depend on the other lanes.
template <class T> Decomposition<T> decompose(const Mat3<T>& F);

}  // namespace firn
