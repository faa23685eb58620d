#pragma once
#include "sim/pack.h"
#include "sim/types.h"

namespace firn {

/// A symmetric 3×3 matrix by its six numbers.
template <class T> struct Symmetric {
    T xx, xy, xz, yy, yz, zz;

    static Symmetric identity() { return {T(1), T(0), T(0), T(1), T(0), T(1)}; }
    T operator()(int i) const { return (&xx)[i]; }

    Symmetric operator+(const Symmetric& b) const { return {xx + b.xx, xy + b.xy, xz + b.xz, yy + b.yy, yz + b.yz, zz + b.zz}; }
    Symmetric operator-(const Symmetric& b) const { return {xx - b.xx, xy - b.xy, xz - b.xz, yy - b.yy, yz - b.yz, zz - b.zz}; }
    Symmetric operator*(T a) const { return {xx * a, xy * a, xz * a, yy * a, yz * a, zz * a}; }

    T trace() const { return xx + yy + zz; }
    /// The sum of the three 2×2 minors on the diagonal.
    T second_invariant() const { return (xx * yy - xy * xy) + (xx * zz - xz * xz) + (yy * zz - yz * yz); }
    T determinant() const { return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz); }
    T squared_norm() const { return xx * xx + yy * yy + zz * zz + T(2) * (xy * xy + xz * xz + yz * yz); }
    Symmetric squared() const {
        return {xx * xx + xy * xy + xz * xz, xx * xy + xy * yy + xz * yz, xx * xz + xy * yz + xz * zz,
                xy * xy + yy * yy + yz * yz, xy * xz + yy * yz + yz * zz, xz * xz + yz * yz + zz * zz};
    }
    Symmetric inverse() const {
        const T a = yy * zz - yz * yz, b = yz * xz - xy * zz, c = xy * yz - yy * xz;
        return Symmetric{a, b, c, xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy} * (T(1) / (xx * a + xy * b + xz * c));
    }
    Vec3<T> operator*(const Vec3<T>& a) const {
        return {xx * a(0) + xy * a(1) + xz * a(2), xy * a(0) + yy * a(1) + yz * a(2), xz * a(0) + yz * a(1) + zz * a(2)};
    }
    Mat3<T> matrix() const {
        Mat3<T> M;
        M << xx, xy, xz, xy, yy, yz, xz, yz, zz;
        return M;
    }
};

template <class T> Symmetric<T> select(auto where, const Symmetric<T>& a, const Symmetric<T>& b) {
    return {select(where, a.xx, b.xx), select(where, a.xy, b.xy), select(where, a.xz, b.xz),
            select(where, a.yy, b.yy), select(where, a.yz, b.yz), select(where, a.zz, b.zz)};
}

/// All eigenvalues above 0: the leading minors are (Sylvester).
template <class T> auto positive_definite(const Symmetric<T>& A) {
    return (A.xx > T(0)) & (A.xx * A.yy - A.xy * A.xy > T(0)) & (A.determinant() > T(0));
}

/// Q diag(d) Qᵀ
template <class T> Symmetric<T> turned(const Mat3<T>& Q, const Vec3<T>& d) {
    const Mat3<T> Qd = Q * d.asDiagonal();
    return {Qd.row(0).dot(Q.row(0)), Qd.row(0).dot(Q.row(1)), Qd.row(0).dot(Q.row(2)),
            Qd.row(1).dot(Q.row(1)), Qd.row(1).dot(Q.row(2)), Qd.row(2).dot(Q.row(2))};
}

/// X = Q diag(x) Qᵀ
template <class T> struct Eigensystem { Mat3<T> Q; Vec3<T> x; };

/// Jacobi's method, for X of the size of 1 or less: turns the plane of two axes until what couples them is below the
/// round-off of 1, for all three pairs. T: a number or a pack, a lane of which does not depend on the others.
template <class T> Eigensystem<T> eigensystem(const Symmetric<T>& X) {
    using Scalar = typename ScalarOf<T>::type;
    constexpr Scalar small = std::numeric_limits<Scalar>::epsilon() / 4;
    Eigensystem<T> e{Mat3<T>::Identity(), {X.xx, X.yy, X.zz}};
    Vec3<T> couples(X.yz, X.xz, X.xy);      // couples(r): of the two axes other than r
    const auto turn = [&](int r) {
        const int p = (r + 1) % 3, q = (r + 2) % 3;
        const T c = couples(r);
        const auto needed = c * c > T(small * small);
        if (!any(needed)) return false;
        const T zeta = (e.x(q) - e.x(p)) / select(needed, T(c + c), T(1));
        const T root = absolute(zeta) + sqrt(T(1) + zeta * zeta);
        const T t = select(needed, select(zeta < T(0), T(-1), T(1)) / root, T(0));
        const T cosine = T(1) / sqrt(T(1) + t * t), sine = t * cosine;
        e.x(p) -= t * c, e.x(q) += t * c;
        couples(r) = select(needed, T(0), c);
        const T pr = couples(q), qr = couples(p);
        couples(q) = cosine * pr - sine * qr, couples(p) = sine * pr + cosine * qr;
        for (int i = 0; i < 3; ++i) {
            const T a = e.Q(i, p), b = e.Q(i, q);
            e.Q(i, p) = cosine * a - sine * b, e.Q(i, q) = sine * a + cosine * b;
        }
        return true;
    };
    for (int sweep = 0; sweep < 10; ++sweep)
        if (const bool a = turn(0), b = turn(1), c = turn(2); !(a || b || c)) break;
    return e;
}

}  // namespace firn
