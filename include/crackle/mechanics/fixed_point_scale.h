// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace crackle::mechanics {

/// What a moving body's state is expected to reach; the fixed-point numbers span a little more.
struct StateRange {
  double displacement;  ///< of a node [m]
  double velocity;      ///< of a node [m/s]
  double force;         ///< that an edge hands on, and at a node [N]
};

/// The quanta of a fixed-point state: powers of two, so that conversions are exact where numbers fit.
struct FixedPointScale {
  double displacement;  ///< [m]
  double velocity;      ///< [m/s]
  double force;         ///< [N]
};

/// The finest quanta whose integers hold the range: 32-bit ones for Real = float, 64-bit ones for
/// Real = double. (Of the 64-bit integers 51 bits are used where they are converted, and ten bits are kept
/// as head room; see kernels/lanes.h.)
template <class Real>
FixedPointScale fixed_point_scale(const StateRange& range);

}  // namespace crackle::mechanics
