// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>  // defines __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace crackle {

/// Returns freed memory of this process to the system. The C library does so by itself only for large blocks:
/// a tessellation consists of many small ones and leaves several times the memory of its mesh behind.
inline void release_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace crackle
