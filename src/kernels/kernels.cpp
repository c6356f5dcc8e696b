// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels.h"

#include "kernels_table.h"

namespace crackle::kernels {

template <>
const Kernels<float>& kernels<float>([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernels_avx512_float;
  if (set == InstructionSet::avx2) return kernels_avx2_float;
#endif
  return kernels_generic_float;
}

template <>
const Kernels<double>& kernels<double>([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernels_avx512_double;
  if (set == InstructionSet::avx2) return kernels_avx2_double;
#endif
  return kernels_generic_double;
}

}  // namespace crackle::kernels
