// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"

#include <array>

/// Symmetric tensors for the kernels. Every function has a fixed order of operations, so results are bitwise
/// equal wherever the tetrahedron is computed.
namespace crackle::mechanics {

using Symmetric = std::array<double, 6>;  ///< xx, yy, zz, yz, xz, xy

inline Vector apply(const Symmetric& s, const Vector& v) {
  return {s[0] * v[0] + s[5] * v[1] + s[4] * v[2], s[5] * v[0] + s[1] * v[1] + s[3] * v[2],
          s[4] * v[0] + s[3] * v[1] + s[2] * v[2]};
}

/// (a b^T + b a^T) / 2
inline Symmetric symmetric_product(const Vector& a, const Vector& b) {
  return {a[0] * b[0],
          a[1] * b[1],
          a[2] * b[2],
          0.5 * (a[1] * b[2] + a[2] * b[1]),
          0.5 * (a[0] * b[2] + a[2] * b[0]),
          0.5 * (a[0] * b[1] + a[1] * b[0])};
}

/// Double contraction a : b.
inline double contract(const Symmetric& a, const Symmetric& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}

}  // namespace crackle::mechanics
