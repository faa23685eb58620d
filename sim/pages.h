#pragma once
#include <cstdlib>
#include <new>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace firn {

/// Memory for what every step runs through from end to end: large arrays come in pages of 2 MiB where the system has
/// them, of which a processor can keep more in mind than of those of 4 KiB (8 % of an explicit step).
template <class T> struct PageAllocator {
    using value_type = T;
    static constexpr std::size_t huge = std::size_t(2) << 20;

    PageAllocator() = default;
    template <class U> PageAllocator(const PageAllocator<U>&) {}
    template <class U> bool operator==(const PageAllocator<U>&) const { return true; }

    T* allocate(std::size_t n) {
        const std::size_t bytes = n * sizeof(T), align = bytes >= huge ? huge : 64;
        void* p = nullptr;
        if (posix_memalign(&p, align, bytes) != 0) throw std::bad_alloc();
#ifdef __linux__
        if (bytes >= huge) madvise(p, bytes / huge * huge, MADV_HUGEPAGE);  // a wish: the system may not grant it
#endif
        return static_cast<T*>(p);
    }
    void deallocate(T* p, std::size_t) { std::free(p); }
};

template <class T> using Pages = std::vector<T, PageAllocator<T>>;

}  // namespace firn
