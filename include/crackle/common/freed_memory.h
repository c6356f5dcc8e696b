// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>  // says which C library this is

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace crackle {

/// Gives memory that this process has freed back to the system. The C library does so by itself only for
/// large pieces: a tessellation is made of many small ones and leaves several times the memory of its mesh
/// behind.
inline void release_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace crackle
