// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels.h"

#include "kernels_table.h"

namespace crackle::kernels {

template <>
const Kernels<float>& kernels<float>([[maybe_unused]] InstructionSet set, bool watches) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return watches ? kernels_avx512_watched_float : kernels_avx512_float;
  if (set == InstructionSet::avx2) return watches ? kernels_avx2_watched_float : kernels_avx2_float;
#endif
  return watches ? kernels_generic_watched_float : kernels_generic_float;
}

template <>
const Kernels<double>& kernels<double>([[maybe_unused]] InstructionSet set, bool) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernels_avx512_double;
  if (set == InstructionSet::avx2) return kernels_avx2_double;
#endif
  return kernels_generic_double;
}

const CellKernels& cell_kernels([[maybe_unused]] InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return cell_kernels_avx512;
  if (set == InstructionSet::avx2) return cell_kernels_avx2;
#endif
  return cell_kernels_generic;
}

}  // namespace crackle::kernels
