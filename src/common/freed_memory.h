// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>  // defines __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace crackle {

/// Returns freed memory of this process to the system. The C library does so by itself only for large blocks:
/// a tessellation consists of many small ones and leaves several times the memory of its mesh behind. A
/// little stays: to give it back and to get it anew takes longer than to compute a small sample.
inline void release_freed_memory() {
#ifdef __GLIBC__
#if __GLIBC_PREREQ(2, 33)
  constexpr std::size_t little = 8 << 20;  // [byte]
  if (mallinfo2().fordblks < little) return;
#endif
  malloc_trim(0);
#endif
}

}  // namespace crackle
