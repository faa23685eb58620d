#pragma once
#include <array>
#include <bit>
#include <cstdint>

namespace firn {

/// How much mass is strained how fast: a histogram of ‖∇v_p‖² with eight bins an octave. Snow that has come apart counts by
/// what is left of its stiffness, exp(ξ (1 − J_P)): how it is strained moves nothing else. Masses are whole numbers, so that
/// their sums do not depend on the order of the threads.
class StrainRates {
public:
    /// A share of the whole mass [1] as the whole number of its 2⁻⁴⁰ths.
    static std::uint64_t units(double share) { return static_cast<std::uint64_t>(share * 0x1p40); }
    void add(float rate2, std::uint64_t mass) { mass_[bin(rate2)] += mass; }
    void add(const StrainRates& other) {
        for (int i = 0; i < bins; ++i) mass_[i] += other.mass_[i];
    }
    /// The rate² that all but `share` of the whole mass stays below [1/s²], to a bin's width above.
    double above_all_but(double share) const {
        std::uint64_t above = 0;
        int i = bins - 1;
        for (; i > 0; --i)
            if (above += mass_[i]; above > units(share)) break;
        return i == 0 ? 0 : std::bit_cast<float>(std::uint32_t(i + first + 1) << shift);
    }

private:
    static constexpr int shift = 20, first = (127 - 40) << 3, bins = 100 << 3;     // 2⁻⁴⁰ to 2⁶⁰
    static int bin(float rate2) {
        const int i = static_cast<int>(std::bit_cast<std::uint32_t>(rate2) >> shift) - first;
        return i < 0 ? 0 : i < bins ? i : bins - 1;
    }
    std::array<std::uint64_t, bins> mass_{};
};

}  // namespace firn
