#pragma once
#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

namespace firn {

constexpr int lanes = 8;  ///< particles that are worked on at once.

template <class T, int W> struct LanesOf { typedef T type __attribute__((vector_size(W * sizeof(T)))); };

/// W numbers on which one instruction works at once (a compiler vector). Arithmetic, comparison and the
/// functions below work lane by lane, and read the same for a plain float or double.
template <class T, int W> struct Pack {
    using Lanes = typename LanesOf<T, W>::type;
    struct Mask {                           ///< −1 where true, 0 where false.
        decltype(Lanes{} < Lanes{}) lanes;
        bool operator[](int i) const { return lanes[i] != 0; }
        friend Mask operator&(Mask a, Mask b) { return {a.lanes & b.lanes}; }
        friend Mask operator|(Mask a, Mask b) { return {a.lanes | b.lanes}; }
        friend Mask operator!(Mask a) { return {~a.lanes}; }
    };
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
        std::uint64_t words[sizeof c.lanes / 8], all = 0;
        std::memcpy(words, &c.lanes, sizeof words);
        for (const std::uint64_t w : words) all |= w;
        return all != 0;
    }
    friend Pack sqrt(Pack a) {
        for (int i = 0; i < W; ++i) a.lanes[i] = std::sqrt(a.lanes[i]);
        return a;
    }
    friend Pack cbrt(Pack a) {
        for (int i = 0; i < W; ++i) a.lanes[i] = std::cbrt(a.lanes[i]);
        return a;
    }
    friend Pack floor(Pack a) {
        for (int i = 0; i < W; ++i) a.lanes[i] = std::floor(a.lanes[i]);
        return a;
    }
    /// The numbers cut to integers; they must be in the range of int.
    friend std::array<int, W> integers(Pack a) {
        typedef int Ints __attribute__((vector_size(W * sizeof(int))));
        const Ints cut = __builtin_convertvector(a.lanes, Ints);
        std::array<int, W> result;
        std::memcpy(result.data(), &cut, sizeof cut);
        return result;
    }
    friend Pack<double, W> doubles(Pack a) {
        return Pack<double, W>::of(__builtin_convertvector(a.lanes, typename Pack<double, W>::Lanes));
    }
};

inline float select(bool c, float a, float b) { return c ? a : b; }
inline double select(bool c, double a, double b) { return c ? a : b; }
inline bool any(bool c) { return c; }
using std::cbrt;
using std::exp;
using std::floor;
using std::sqrt;

template <class T> T absolute(T a) { return select(a < T(0), T(-a), a); }
template <class T> T minimum(T a, T b) { return select(b < a, b, a); }
template <class T> T maximum(T a, T b) { return select(a < b, b, a); }
template <class T> T clamp(T a, T low, T high) { return minimum(maximum(a, low), high); }

/// Orders of eight numbers for __builtin_shuffle: from 8 on they stand for those of a second pack.
template <class T> struct OrderOf { typedef std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t> type __attribute__((vector_size(8 * sizeof(T)))); };

/// The lower half of one pack and the upper half of another.
template <class T> Pack<T, 8> halves(Pack<T, 8> low, Pack<T, 8> high) {
    return Pack<T, 8>::of(__builtin_shuffle(low.lanes, high.lanes, typename OrderOf<T>::type{0, 1, 2, 3, 12, 13, 14, 15}));
}
/// The upper half first.
template <class T> Pack<T, 8> exchanged(Pack<T, 8> a) {
    return Pack<T, 8>::of(__builtin_shuffle(a.lanes, typename OrderOf<T>::type{4, 5, 6, 7, 0, 1, 2, 3}));
}

/// e^a to two units in the last place: a = n ln 2 + r, |r| ≤ ln 2 / 2, e^r by its series. Overflows to a number of
/// more than 10³⁸, underflows to one of less than 10⁻³⁷.
template <class T, int W> Pack<T, W> exp(Pack<T, W> a) {
    using P = Pack<T, W>;
    using Int = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
    typedef Int Ints __attribute__((vector_size(W * sizeof(Int))));
    constexpr bool single = sizeof(T) == 4;
    constexpr int digits = std::numeric_limits<T>::digits - 1, terms = single ? 7 : 13;
    a = clamp(a, P(single ? T(-87) : T(-708)), P(single ? T(88.7) : T(709.7)));
    const P n = floor(a * P(T(1.4426950408889634)) + P(T(0.5)));
    // ln 2 in two parts, the first with so few digits that n times it is exact.
    const P r = a - n * P(single ? T(0.693359375) : T(0.693147180369123816490))
                  - n * P(single ? T(-2.12194440e-4) : T(1.90821492927058770002e-10));
    P sum(1);
    for (int k = terms; k > 0; --k) sum = P(1) + sum * (r * P(T(1) / T(k)));
    Ints exponent = __builtin_convertvector(n.lanes, Ints);
    // 2ⁿ as 2^(n/2) 2^(n − n/2), since 2^128 is no float.
    const Ints half = exponent >> 1;
    const auto power = [](Ints e) {
        const Ints bits = (e + (std::numeric_limits<T>::max_exponent - 1)) << digits;
        typename P::Lanes l;
        std::memcpy(&l, &bits, sizeof l);
        return P::of(l);
    };
    return sum * power(half) * power(exponent - half);
}

/// Rows to columns: number j of pack i becomes number i of pack j. Eight numbers of eight particles: from a particle in
/// each lane to a particle in each pack, and back.
template <class T> void transpose(std::array<Pack<T, 8>, 8>& rows) {
    using P = Pack<T, 8>;
    using Order = typename OrderOf<T>::type;
    const auto mix = [&](const std::array<P, 8>& a, int distance, Order low, Order high) {
        std::array<P, 8> r;
#pragma GCC unroll 8
        for (int i = 0; i < 8; ++i) {
            if ((i & distance) != 0) continue;
            r[i] = P::of(__builtin_shuffle(a[i].lanes, a[i + distance].lanes, low));
            r[i + distance] = P::of(__builtin_shuffle(a[i].lanes, a[i + distance].lanes, high));
        }
        return r;
    };
    rows = mix(rows, 1, Order{0, 8, 2, 10, 4, 12, 6, 14}, Order{1, 9, 3, 11, 5, 13, 7, 15});
    rows = mix(rows, 2, Order{0, 1, 8, 9, 4, 5, 12, 13}, Order{2, 3, 10, 11, 6, 7, 14, 15});
    rows = mix(rows, 4, Order{0, 1, 2, 3, 8, 9, 10, 11}, Order{4, 5, 6, 7, 12, 13, 14, 15});
}

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
