// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace crackle {

/// An allocator that asks the system for huge pages where an array fills at least one: a sweep over many
/// megabytes otherwise waits for address translations.
template <class T>
struct HugePages {
  using value_type = T;

  HugePages() = default;
  template <class U>
  HugePages(const HugePages<U>&) {}

  T* allocate(std::size_t n) {
    constexpr std::size_t page = std::size_t{1} << 21, cache_line = 64;
    const bool fills_page = n * sizeof(T) >= page;
    const std::size_t unit = fills_page ? page : std::max(alignof(T), cache_line);
    const std::size_t bytes = (n * sizeof(T) + unit - 1) / unit * unit;
    void* const memory = std::aligned_alloc(unit, bytes);
    if (memory == nullptr) throw std::bad_alloc();
#if defined(MADV_HUGEPAGE)
    // Advice: the memory is as good without.
    if (fills_page) madvise(memory, bytes, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) {
    std::free(memory);
  }

  friend bool operator==(const HugePages&, const HugePages&) {
    return true;
  }
};

/// A vector for the arrays that every time step sweeps over.
template <class T>
using LargeVector = std::vector<T, HugePages<T>>;

}  // namespace crackle
