// SPDX-License-Identifier: GPL-3.0-or-later
#include "kernels_body.h"
#include "kernels_table.h"

namespace crackle::kernels {

const Kernels<float> kernels_generic_float = all_kernels<float>();
const Kernels<double> kernels_generic_double = all_kernels<double>();

}  // namespace crackle::kernels
