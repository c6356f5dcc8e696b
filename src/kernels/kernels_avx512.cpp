// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels_body.h"
#include "kernels_table.h"

namespace crackle::kernels {

const Kernels<float> kernels_avx512_float = all_kernels<float>();
const Kernels<double> kernels_avx512_double = all_kernels<double>();

}  // namespace crackle::kernels
