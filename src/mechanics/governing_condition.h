// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"
#include "input/model.h"

#include <vector>

namespace crackle::mechanics {

/// A boundary condition, body force or tool that contributes to the load curve of a sample.
struct GoverningCondition {
  int condition = 0;  ///< index into the input's boundaries, then its body forces, then its tools
  /// Unit vector along the prescribed quantity, or opposite to the drive for a condition that prescribes no
  /// motion or force itself; zero if undefined. For a pressure, which acts along the normal, x is 1 if it
  /// pushes and -1 if it pulls.
  Vector direction{};
  bool is_support = false;  ///< fixes, absorbs, or prescribes zero
  /// Load per amplitude of a condition that acts in all directions: the loaded area of a pressure [m^2],
  /// times the magnitude of its factor; the sum of magnitudes of the centrifugal forces of a rotation [N].
  double area = 0;
};

/// The conditions whose loads add up to that of the testing machine: all those with the name given by
/// `[output] governing` or, without it, with the name of the driving condition. The driving condition is the
/// first that changes with time, otherwise the first with a non-zero prescribed value; body forces and tools
/// come after the boundaries. Empty if there is none.
///
/// The direction of a condition is that of its rate or, for a velocity or without a rate, that of its value,
/// reversed if the first non-zero factor of its history is negative.
std::vector<GoverningCondition> governing_conditions(const input::Model& model);

}  // namespace crackle::mechanics
