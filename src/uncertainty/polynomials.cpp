// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/uncertainty/polynomials.h"

#include "openturns.h"

namespace crackle::uncertainty {

std::vector<std::vector<double>> orthonormal_polynomials(const input::RandomInput& random,
                                                         std::span<const double> values, int highest_degree) {
  return openturns().orthonormal_polynomials(random, values, highest_degree);
}

}  // namespace crackle::uncertainty
