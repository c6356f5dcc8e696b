// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"

namespace crackle::mechanics {

/// Expected range of a moving body's state; the fixed-point numbers span slightly more.
struct StateRange {
  double stretch;   ///< difference of displacement, in any component, along an edge that carries load [m]
  double velocity;  ///< of a node [m/s]
  double force;     ///< contribution of an edge, and total at a node [N]
  double strain = infinity;  ///< of the intact body; infinity: unknown
};

/// The quanta of a fixed-point state: powers of two, so that conversions are exact if the numbers fit.
///
/// Displacements wrap around: only their differences along edges enter the forces and must fit. Thus
/// displacements are resolved as finely as the stretch of an edge allows, however far the body moves.
struct FixedPointScale {
  double displacement;  ///< [m]
  double velocity;      ///< [m/s]
  double force;         ///< [N]
};

/// The finest quanta for which the range uses half of what the format can convert: 31 bits for Real = float.
/// For Real = double, which converts 51 bits (see kernels/lanes.h), some bits are kept as headroom.
template <class Real>
FixedPointScale fixed_point_scale(const StateRange& range);

}  // namespace crackle::mechanics
