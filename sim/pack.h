#pragma once
#include <Eigen/Core>

#include <cmath>

namespace firn {

template <class T, int W> struct LanesOf { typedef T type __attribute__((vector_size(W * sizeof(T)))); };

/// W numbers on which one instruction works at once (a compiler vector). Arithmetic, comparison and the
/// functions below work lane by lane, and read the same for a plain float or double.
template <class T, int W> struct Pack {
    using Lanes = typename LanesOf<T, W>::type;
    struct Mask { decltype(Lanes{} < Lanes{}) lanes; };  ///< −1 where true, 0 where false.
    Lanes lanes;

    Pack() = default;
    Pack(T a) : lanes(a - Lanes{}) {}
    static Pack of(Lanes l) { Pack p; p.lanes = l; return p; }
    template <class... A> requires(sizeof...(A) == W) static Pack of(A... each) { return of(Lanes{T(each)...}); }
    T operator[](int i) const { return lanes[i]; }

    Pack operator-() const { return of(-lanes); }
    Pack& operator+=(Pack b) { lanes += b.lanes; return *this; }
    Pack& operator-=(Pack b) { lanes -= b.lanes; return *this; }
    Pack& operator*=(Pack b) { lanes *= b.lanes; return *this; }
    Pack& operator/=(Pack b) { lanes /= b.lanes; return *this; }
    friend Pack operator+(Pack a, Pack b) { return of(a.lanes + b.lanes); }
    friend Pack operator-(Pack a, Pack b) { return of(a.lanes - b.lanes); }
    friend Pack operator*(Pack a, Pack b) { return of(a.lanes * b.lanes); }
    friend Pack operator/(Pack a, Pack b) { return of(a.lanes / b.lanes); }
    friend Mask operator<(Pack a, Pack b) { return {a.lanes < b.lanes}; }
    friend Mask operator>(Pack a, Pack b) { return {a.lanes > b.lanes}; }
    friend Pack select(Mask c, Pack a, Pack b) { return of(c.lanes ? a.lanes : b.lanes); }
    friend bool any(Mask c) {
        bool result = false;
        for (int i = 0; i < W; ++i) result |= c.lanes[i] != 0;
        return result;
    }
    friend Pack sqrt(Pack a) {
        Pack b;
        for (int i = 0; i < W; ++i) b.lanes[i] = std::sqrt(a.lanes[i]);
        return b;
    }
    friend Pack exp(Pack a) {
        Pack b;
        for (int i = 0; i < W; ++i) b.lanes[i] = std::exp(a.lanes[i]);
        return b;
    }
};

inline float select(bool c, float a, float b) { return c ? a : b; }
inline double select(bool c, double a, double b) { return c ? a : b; }
inline bool any(bool c) { return c; }
using std::exp;
using std::sqrt;

template <class T> T absolute(T a) { return select(a < T(0), T(-a), a); }
template <class T> T minimum(T a, T b) { return select(b < a, b, a); }
template <class T> T maximum(T a, T b) { return select(a < b, b, a); }
template <class T> T clamp(T a, T low, T high) { return minimum(maximum(a, low), high); }

/// The number type under a pack: Pack<float, 8> → float, double → double.
template <class T> struct ScalarOf { using type = T; };
template <class T, int W> struct ScalarOf<Pack<T, W>> { using type = T; };

}  // namespace firn

/// Lets Eigen's small matrices hold packs: Eigen::Matrix<Pack<float, 8>, 3, 3> is eight matrices.
template <class T, int W> struct Eigen::NumTraits<firn::Pack<T, W>> : Eigen::NumTraits<T> {
    using Real = firn::Pack<T, W>;
    using NonInteger = Real;
    using Nested = Real;
    using Literal = Real;
    enum { RequireInitialization = 0, IsInteger = 0, IsComplex = 0, IsSigned = 1 };
};
