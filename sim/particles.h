#pragma once
#include "sim/pack.h"
#include "sim/types.h"

#include <array>
#include <cstdint>
#include <vector>

namespace firn {

constexpr int lanes = 8;  ///< particles that are worked on at once.

/// C numbers of each particle, in groups of eight particles: all first numbers of a group, then all second
/// ones. What lies behind the last particle of the last group is never read back.
template <class Real, int C> class Field {
public:
    using P = Pack<Real, lanes>;

    void resize(std::size_t n) { groups_.resize((n + lanes - 1) / lanes); }
    void clear() { groups_ = {}; }
    bool empty() const { return groups_.empty(); }
    std::size_t bytes() const { return groups_.size() * sizeof(groups_[0]); }
    char* raw() { return reinterpret_cast<char*>(groups_.data()); }
    const char* raw() const { return reinterpret_cast<const char*>(groups_.data()); }

    Real& at(std::size_t p, int c = 0) { return numbers()[(p / lanes * C + c) * lanes + p % lanes]; }
    Real at(std::size_t p, int c = 0) const {
        return reinterpret_cast<const Real*>(groups_.data())[(p / lanes * C + c) * lanes + p % lanes];
    }
    P& pack(std::size_t group, int c = 0) { return groups_[group][c]; }
    const P& pack(std::size_t group, int c = 0) const { return groups_[group][c]; }

    /// Particle order[p] becomes particle p; `spare` lends its memory and keeps what was here.
    void permute(const std::vector<std::uint32_t>& order, Field& spare) {
        spare.groups_.resize(groups_.size());
        std::swap(groups_, spare.groups_);
        const auto n = static_cast<std::ptrdiff_t>(order.size());
#pragma omp parallel for schedule(static)
        for (std::ptrdiff_t p = 0; p < n; ++p)
            for (int c = 0; c < C; ++c) at(p, c) = spare.at(order[p], c);
    }

private:
    Real* numbers() { return reinterpret_cast<Real*>(groups_.data()); }
    std::vector<std::array<P, C>> groups_;
};

template <class Real> Vec3<Real> vector_of(const Field<Real, 3>& f, std::size_t p) {
    return {f.at(p, 0), f.at(p, 1), f.at(p, 2)};
}
template <class Real> Mat3<Real> matrix_of(const Field<Real, 9>& f, std::size_t p) {
    Mat3<Real> M;
    for (int i = 0; i < 9; ++i) M(i) = f.at(p, i);
    return M;
}
template <class Real> Vec3<Pack<Real, lanes>> vectors_of(const Field<Real, 3>& f, std::size_t group) {
    return {f.pack(group, 0), f.pack(group, 1), f.pack(group, 2)};
}
template <class Real> Mat3<Pack<Real, lanes>> matrices_of(const Field<Real, 9>& f, std::size_t group) {
    Mat3<Pack<Real, lanes>> M;
    for (int i = 0; i < 9; ++i) M(i) = f.pack(group, i);
    return M;
}
template <class Real, int C, class Values> void store(Field<Real, C>& f, std::size_t group, const Values& values) {
    for (int i = 0; i < C; ++i) f.pack(group, i) = values(i);
}

/// What is known of every particle. Matrices column by column.
template <class Real> struct Particles {
    std::size_t n = 0;
    Field<Real, 3> x;                       ///< position [m]
    Field<Real, 3> v;                       ///< velocity [m/s]
    Field<Real, 9> Fe;                      ///< elastic deformation gradient [1]
    Field<Real, 1> Jp;                      ///< det F_P [1]
    Field<Real, 6> tau;                     ///< P F_Eᵀ [Pa], symmetric: xx xy xz yy yz zz; follows from Fe, Jp.
    Field<Real, 9> C;                       ///< APIC's affine velocity [1/s]; empty under FLIP.
    Field<Real, 1> m, V0;                   ///< mass [kg], initial volume [m³]
    std::vector<std::uint8_t> material;     ///< index of its Snow; empty where there is one only.
    std::vector<std::uint32_t> id;          ///< place in the order of sampling.

    /// Every field of numbers, for what treats them all alike.
    template <class F> void for_each_field(F&& f) { f(x), f(v), f(Fe), f(Jp), f(tau), f(C), f(m), f(V0); }
    template <class F> void for_each_field(F&& f) const { f(x), f(v), f(Fe), f(Jp), f(tau), f(C), f(m), f(V0); }

    Mat3<Real> stress(std::size_t p) const {
        Mat3<Real> t;
        t << tau.at(p, 0), tau.at(p, 1), tau.at(p, 2), tau.at(p, 1), tau.at(p, 3), tau.at(p, 4), tau.at(p, 2),
            tau.at(p, 4), tau.at(p, 5);
        return t;
    }
};

/// The six numbers of a symmetric matrix, as `Particles::tau` keeps them.
template <class T> Eigen::Matrix<T, 6, 1> upper_triangle(const Mat3<T>& S) {
    Eigen::Matrix<T, 6, 1> s;
    s << S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2);
    return s;
}

}  // namespace firn
