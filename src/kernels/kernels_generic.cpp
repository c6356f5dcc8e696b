// SPDX-License-Identifier: GPL-3.0-or-later
#include "cell_kernels_body.h"
#include "kernels_body.h"
#include "kernels_table.h"

namespace crackle::kernels {

const Kernels<float> kernels_generic_float = all_kernels<float, false>();
const Kernels<float> kernels_generic_watched_float = all_kernels<float, true>();
const Kernels<double> kernels_generic_double = all_kernels<double, true>();

const CellKernels cell_kernels_generic = all_cell_kernels();

}  // namespace crackle::kernels
