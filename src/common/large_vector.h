// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

namespace crackle {

/// An allocator that asks the system for huge pages where an array fills at least one: a sweep over many
/// megabytes otherwise waits for address translations. Such an array gets fresh memory, since pages that were
/// in use stay small.
template <class T>
class HugePages {
public:
  using value_type = T;

  HugePages() = default;
  template <class U>
  HugePages(const HugePages<U>&) {}

  T* allocate(std::size_t n) {
    void* const memory =
        fills_page(n) ? mapped(in_units(n, page)) : std::aligned_alloc(alignment, in_units(n, alignment));
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t n) {
    if (fills_page(n))
      munmap(memory, in_units(n, page));
    else
      std::free(memory);
  }

  friend bool operator==(const HugePages&, const HugePages&) { return true; }

private:
  static constexpr std::size_t page = std::size_t{1} << 21;
  static constexpr std::size_t alignment = std::max<std::size_t>(alignof(T), 64);

  static bool fills_page(std::size_t n) { return n * sizeof(T) >= page; }
  /// Bytes of n objects, rounded up.
  static std::size_t in_units(std::size_t n, std::size_t unit) {
    return (n * sizeof(T) + unit - 1) / unit * unit;
  }

  /// @return memory that starts at a huge page; nullptr if there is none
  static void* mapped(std::size_t size) {
    void* const all = mmap(nullptr, size + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED) return nullptr;
    const std::size_t before = (page - reinterpret_cast<std::uintptr_t>(all) % page) % page;
    char* const start = static_cast<char*>(all) + before;
    if (before > 0) munmap(all, before);
    munmap(start + size, page - before);
#if defined(MADV_HUGEPAGE)
    madvise(start, size, MADV_HUGEPAGE);  // advice: the memory is as good without
#endif
    return start;
  }
};

/// A vector for the arrays that every time step sweeps over.
template <class T>
using LargeVector = std::vector<T, HugePages<T>>;

}  // namespace crackle
