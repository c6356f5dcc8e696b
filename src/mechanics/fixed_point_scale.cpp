// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/fixed_point_scale.h"

#include <cmath>

namespace crackle::mechanics {

namespace {

/// The smallest power of two q with 2^bits q at least `range`.
double quantum(double range, int bits) {
  return std::ldexp(1.0, std::ilogb(range) + 1 - bits);
}

}  // namespace

template <>
FixedPointScale fixed_point_scale<float>(const StateRange& range) {
  return {quantum(range.stretch, 30), quantum(range.velocity, 30), quantum(range.force, 30)};
}

template <>
FixedPointScale fixed_point_scale<double>(const StateRange& range) {
  return {quantum(range.stretch, 42), quantum(range.velocity, 46), quantum(range.force, 46)};
}

}  // namespace crackle::mechanics
