// SPDX-License-Identifier: GPL-3.0-or-later
#include "cell_kernels_body.h"
#include "kernels_body.h"
#include "kernels_table.h"

namespace crackle::kernels {

const Kernels<float> kernels_avx2_float = all_kernels<float, false>();
const Kernels<float> kernels_avx2_watched_float = all_kernels<float, true>();
const Kernels<double> kernels_avx2_double = all_kernels<double, true>();

const CellKernels cell_kernels_avx2 = all_cell_kernels();

}  // namespace crackle::kernels
