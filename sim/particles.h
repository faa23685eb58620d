#pragma once
#include "sim/extremes.h"
#include "sim/pack.h"
#include "sim/pages.h"
#include "sim/types.h"

#include <array>
#include <cstdint>
#include <vector>

namespace firn {

/// C numbers of each particle, in groups of eight slots: all first numbers of a group, then all second ones.
template <class Real, int C> class Field {
public:
    using P = Pack<Real, lanes>;
    static constexpr int components = C;

    /// New groups hold `value` everywhere. Takes memory for what is asked for, not for twice as much.
    void resize(std::size_t groups, const std::array<Real, C>& value) {
        std::array<P, C> filled;
        for (int c = 0; c < C; ++c) filled[c] = P(value[c]);
        if (groups > groups_.capacity()) groups_.reserve(groups);
        groups_.resize(groups, filled);
    }
    bool empty() const { return groups_.empty(); }

    Real& at(std::size_t slot, int c = 0) { return numbers()[(slot / lanes * C + c) * lanes + slot % lanes]; }
    const Real& at(std::size_t slot, int c = 0) const {
        return reinterpret_cast<const Real*>(groups_.data())[(slot / lanes * C + c) * lanes + slot % lanes];
    }
    std::array<P, C>& group(std::size_t g) { return groups_[g]; }
    const std::array<P, C>& group(std::size_t g) const { return groups_[g]; }
    /// Has a group fetched from memory, to be there when it is worked on.
    void prefetch(std::size_t g) const {
        const char* bytes = reinterpret_cast<const char*>(&groups_[g]);
        for (std::size_t i = 0; i < sizeof groups_[g]; i += 64) __builtin_prefetch(bytes + i);
    }
    P& pack(std::size_t group, int c = 0) { return groups_[group][c]; }
    const P& pack(std::size_t group, int c = 0) const { return groups_[group][c]; }

private:
    Real* numbers() { return reinterpret_cast<Real*>(groups_.data()); }
    Pages<std::array<P, C>> groups_;
};

template <class Real> Vec3<Real> vector_of(const Field<Real, 3>& f, std::size_t slot) {
    return {f.at(slot, 0), f.at(slot, 1), f.at(slot, 2)};
}
template <class Real> Mat3<Real> matrix_of(const Field<Real, 9>& f, std::size_t slot) {
    Mat3<Real> M;
    for (int i = 0; i < 9; ++i) M(i) = f.at(slot, i);
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

/// A block asleep ("sim/rest.h").
template <class Real> struct Lump {
    double mass = 0;                        ///< M [kg]
    Vec3d velocity{0, 0, 0};                ///< u [m/s]
    Vec3d next_velocity{0, 0, 0};           ///< after the step that is being taken.
    double way = 0;                         ///< Σ |u| Δt, which it did not go [m].
    Extremes extremes{};                    ///< of its particles, which stand still.
    std::vector<Pack<Real, 8>> nodes{};     ///< (0, m_i | f_i, 0) of those it is linked to; none before they are first reckoned.
};

/// What is known of every particle. Matrices column by column. Each is in a slot: number slot % 8 of group slot / 8;
/// a group belongs to one block or to none. What has no mass is no particle: an empty slot.
template <class Real> struct Particles {
    std::size_t groups = 0;
    Field<Real, 3> x;                       ///< position [m]
    Field<Real, 3> v;                       ///< velocity [m/s]
    Field<Real, 9> Fe;                      ///< elastic deformation gradient [1]
    Field<Real, 1> Jp;                      ///< det F_P [1]
    Field<Real, 6> tau;                     ///< P F_Eᵀ [Pa], symmetric: xx xy xz yy yz zz; follows from Fe, Jp.
    Field<Real, 9> C;                       ///< APIC's affine velocity [1/s]; empty under FLIP.
    Field<Real, 1> m, V0;                   ///< mass [kg], initial volume [m³]
    std::vector<std::uint8_t> material;     ///< index of its Snow; empty where there is one only.
    std::vector<std::uint32_t> id;          ///< place in the order of sampling.
    std::vector<std::uint32_t> free_groups;
    std::vector<Lump<Real>> lumps;          ///< blocks asleep; one without mass is free.
    bool affine = false;                    ///< C is kept.
    bool several_materials = false;         ///< `material` is kept.

    /// Index of a particle's Snow.
    std::size_t material_of(std::size_t slot) const { return several_materials ? material[slot] : 0; }
    /// All slots that are new are empty, and harmless to reckon with.
    void resize(std::size_t count) {
        groups = count;
        x.resize(groups, {}), v.resize(groups, {}), Fe.resize(groups, {1, 0, 0, 0, 1, 0, 0, 0, 1}), Jp.resize(groups, {1});
        tau.resize(groups, {}), m.resize(groups, {}), V0.resize(groups, {});
        if (affine) C.resize(groups, {});
        if (several_materials) material.resize(lanes * groups, 0);
        id.resize(lanes * groups, 0);
    }
    /// A group that no block has.
    std::uint32_t new_group() {
        if (free_groups.empty()) {
            const std::size_t more = groups / 32 + 16;
            resize(groups + more);
            for (std::size_t i = 1; i <= more; ++i) free_groups.push_back(static_cast<std::uint32_t>(groups - i));
        }
        const std::uint32_t g = free_groups.back();
        free_groups.pop_back();
        return g;
    }
    /// All that is known of one particle.
    struct One {
        Real numbers[34];
        std::uint32_t id;
        std::uint8_t material;
    };
    One get(std::size_t slot) const {
        One one;
        one.id = id[slot];
        if (several_materials) one.material = material[slot];
        Real* next = one.numbers;
        for_each_field([&](const auto& field) {
            const Real* numbers = &field.at(slot);
            for (int c = 0; c < field.components; ++c) *next++ = numbers[lanes * c];
        });
        return one;
    }
    void put(std::size_t slot, const One& one) {
        const Real* next = one.numbers;
        for_each_field([&](auto& field) {
            Real* numbers = &field.at(slot);
            for (int c = 0; c < field.components; ++c) numbers[lanes * c] = *next++;
        });
        id[slot] = one.id;
        if (several_materials) material[slot] = one.material;
    }
    /// A slot without mass, volume and velocity does no harm to what is reckoned beside it.
    void empty(std::size_t slot) {
        m.at(slot) = V0.at(slot) = 0;
        for (int a = 0; a < 3; ++a) v.at(slot, a) = 0;
    }
    /// Every field of numbers that there is, for what treats them all alike.
    template <class F> void for_each_field(F&& f) const {
        f(x), f(v), f(Fe), f(Jp), f(tau), f(m), f(V0);
        if (affine) f(C);
    }
    template <class F> void for_each_field(F&& f) {
        f(x), f(v), f(Fe), f(Jp), f(tau), f(m), f(V0);
        if (affine) f(C);
    }
};

}  // namespace firn
