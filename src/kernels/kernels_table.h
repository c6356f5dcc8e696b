// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cell_kernels.h"
#include "kernels.h"

namespace crackle::kernels {

extern const Kernels<float> kernels_generic_float;
extern const Kernels<float> kernels_generic_watched_float;
extern const Kernels<double> kernels_generic_double;
extern const CellKernels cell_kernels_generic;
#if defined(__x86_64__)
extern const Kernels<float> kernels_avx2_float;
extern const Kernels<float> kernels_avx2_watched_float;
extern const Kernels<double> kernels_avx2_double;
extern const CellKernels cell_kernels_avx2;
extern const Kernels<float> kernels_avx512_float;
extern const Kernels<float> kernels_avx512_watched_float;
extern const Kernels<double> kernels_avx512_double;
extern const CellKernels cell_kernels_avx512;
#endif

}  // namespace crackle::kernels
