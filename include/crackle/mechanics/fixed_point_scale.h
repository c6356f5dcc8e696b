// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"

namespace crackle::mechanics {

/// What a moving body's state is expected to reach; the fixed-point numbers span a little more.
struct StateRange {
  double stretch;            ///< difference of displacement, in any component, along an edge that carries [m]
  double velocity;           ///< of a node [m/s]
  double force;              ///< that an edge hands on, and at a node [N]
  double strain = infinity;  ///< of the body while it is whole; infinity: not told
};

/// The quanta of a fixed-point state: powers of two, so that conversions are exact where numbers fit.
///
/// Displacements wrap around: only their differences along edges enter the forces, and these must fit. So
/// a displacement can be resolved as finely as the stretch of an edge allows, however far the body moves.
struct FixedPointScale {
  double displacement;  ///< [m]
  double velocity;      ///< [m/s]
  double force;         ///< [N]
};

/// The finest quanta with which the range uses half of what the format converts, 31 bits, for Real = float.
/// For Real = double, which converts 51 bits (see kernels/lanes.h), some are kept as head room.
template <class Real>
FixedPointScale fixed_point_scale(const StateRange& range);

}  // namespace crackle::mechanics
