// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/mechanics/tensor.h"

#include <algorithm>
#include <cmath>

namespace crackle::fracture {

/// Largest principal value of a symmetric tensor, by additions, multiplications, divisions and square roots
/// only, so that it has the same bits with every mathematical library.
double largest_principal(const mechanics::Symmetric& tensor);

/// An upper bound of the largest principal value from the invariants: tr/3 + sqrt(4/3 J2). It is attained in
/// uniaxial tension. Far cheaper than the value itself.
inline double largest_principal_bound(const mechanics::Symmetric& s) {
  const double mean = (s[0] + s[1] + s[2]) / 3;
  const double d0 = s[0] - mean, d1 = s[1] - mean, d2 = s[2] - mean;
  const double j2 = 0.5 * (d0 * d0 + d1 * d1 + d2 * d2) + s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
  return mean + std::sqrt(4.0 / 3.0 * j2);
}

/// Far above what rounding does to the largest principal value and to its bound.
inline double principal_rounding(const mechanics::Symmetric& s) {
  double sum = 0;
  for (const double component : s) sum += std::abs(component);
  return 1e-13 * sum;
}

/// Whether the largest principal value is above `strength` (not negative); the bound settles most tensors.
inline bool exceeds(const mechanics::Symmetric& tensor, double strength) {
  // The bound holds up to rounding, hence the last digits' slack.
  return largest_principal_bound(tensor) > strength * (1 - 1e-12) && largest_principal(tensor) > strength;
}

}  // namespace crackle::fracture
