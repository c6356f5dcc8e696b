// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "kernels.h"

namespace crackle::kernels {

extern const Kernels<float> kernels_generic_float;
extern const Kernels<double> kernels_generic_double;
#if defined(__x86_64__)
extern const Kernels<float> kernels_avx2_float;
extern const Kernels<double> kernels_avx2_double;
extern const Kernels<float> kernels_avx512_float;
extern const Kernels<double> kernels_avx512_double;
#endif

}  // namespace crackle::kernels
