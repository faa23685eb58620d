#include "sim/decomposition.h"

#include "sim/particles.h"

#include <limits>

namespace firn {

template <class T> Decomposition<T> decompose(const Mat3<T>& F) {
    using Scalar = typename ScalarOf<T>::type;
    constexpr Scalar epsilon = std::numeric_limits<Scalar>::epsilon();

    // Scaled so that squares neither overflow nor vanish.
    T largest(0);
    for (int i = 0; i < 9; ++i) largest = maximum(largest, absolute(F(i)));
    const T scale = select(largest > T(0), largest, T(1));
    const Mat3<T> A = F / scale;
    Mat3<T> B = A;
    Mat3<T> V = Mat3<T>::Identity();

    // tan 2φ = 2 b_p·b_q / (‖b_p‖² − ‖b_q‖²), the smaller root for tan φ. Columns that are orthogonal to
    // round-off are left alone, which also ends the loop; 12 sweeps are never needed (5 are, for doubles).
    const auto turn = [&](int p, int q) {
        const T a = B.col(p).squaredNorm(), b = B.col(q).squaredNorm(), c = B.col(p).dot(B.col(q));
        const auto needed = c * c > T(epsilon * epsilon) * a * b;
        const T zeta = (b - a) / select(needed, T(2) * c, T(1));
        const T root = absolute(zeta) + sqrt(T(1) + zeta * zeta);
        const T t = select(needed, select(zeta < T(0), T(-1), T(1)) / root, T(0));
        const T cosine = T(1) / sqrt(T(1) + t * t), sine = t * cosine;
        for (Mat3<T>* X : {&B, &V}) {
            const Vec3<T> x = X->col(p);
            X->col(p) = cosine * x - sine * X->col(q);
            X->col(q) = sine * x + cosine * X->col(q);
        }
        return any(needed);
    };
    for (int sweep = 0; sweep < 12; ++sweep)
        if (const bool a = turn(0, 1), b = turn(0, 2), c = turn(1, 2); !(a || b || c)) break;

    // V has gathered the round-off of all turns; one step of Newton's method takes it away.
    const auto orthogonalised = [](const Mat3<T>& Q) -> Mat3<T> {
        return Q * (T(Scalar(1.5)) * Mat3<T>::Identity() - T(Scalar(0.5)) * Q.transpose() * Q);
    };
    V = orthogonalised(V);
    B = A * V;

    // Longest column first. (x, y) → (y, −x) is a quarter turn, so V stays a rotation.
    const auto order = [&](int p, int q) {
        const auto wrong = B.col(p).squaredNorm() < B.col(q).squaredNorm();
        for (Mat3<T>* X : {&B, &V})
            for (int i = 0; i < 3; ++i) {
                const T x = (*X)(i, p), y = (*X)(i, q);
                (*X)(i, p) = select(wrong, y, x);
                (*X)(i, q) = select(wrong, T(-x), y);
            }
    };
    order(0, 1), order(0, 2), order(1, 2);

    // U by orthonormalising B's columns; where they vanish, any direction across the earlier ones will do.
    constexpr Scalar tiny = std::numeric_limits<Scalar>::min() * Scalar(1e4);
    const auto unit = [&](const Vec3<T>& x, const Vec3<T>& otherwise) {
        const T n = x.squaredNorm();
        const auto good = n > T(tiny);
        const T inverse = T(1) / sqrt(select(good, n, T(1)));
        Vec3<T> y;
        for (int i = 0; i < 3; ++i) y(i) = select(good, x(i) * inverse, otherwise(i));
        return y;
    };
    Decomposition<T> d;
    const Vec3<T> u0 = unit(B.col(0), Vec3<T>::UnitX());
    Vec3<T> b1 = B.col(1) - u0.dot(B.col(1)) * u0;
    b1 -= u0.dot(b1) * u0;
    // Across u0: x − y or y − z, whichever is the longer, is never nearly zero.
    const Vec3<T> xy(u0(1), T(-u0(0)), T(0)), yz(T(0), u0(2), T(-u0(1)));
    const auto first = xy.squaredNorm() > yz.squaredNorm();
    Vec3<T> across;
    for (int i = 0; i < 3; ++i) across(i) = select(first, xy(i), yz(i));
    Vec3<T> u1 = unit(b1, unit(across, Vec3<T>::UnitY()));
    const auto backward = u1.dot(B.col(1)) < T(0);
    for (int i = 0; i < 3; ++i) u1(i) = select(backward, T(-u1(i)), u1(i));
    d.U.col(0) = u0;
    d.U.col(1) = u1;
    d.U.col(2) = u0.cross(u1);
    d.U = orthogonalised(d.U);
    for (int i = 0; i < 3; ++i) d.s(i) = scale * d.U.col(i).dot(B.col(i));
    d.V = V;
    return d;
}

template Decomposition<float> decompose(const Mat3<float>&);
template Decomposition<double> decompose(const Mat3<double>&);
template Decomposition<Pack<float, lanes>> decompose(const Mat3<Pack<float, lanes>>&);
template Decomposition<Pack<double, lanes>> decompose(const Mat3<Pack<double, lanes>>&);

}  // namespace firn
