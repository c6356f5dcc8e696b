// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/vector.h"
#include "crackle/input/parameters.h"

#include <vector>

namespace crackle::mechanics {

/// A boundary condition whose load enters the load curve of a sample.
struct GoverningCondition {
  int condition = 0;  ///< index into the input's boundaries
  /// Unit vector: along what it prescribes, or against the drive for a condition that prescribes no motion or
  /// force of its own; zero where nothing tells it. Of a pressure, which acts along the normal, x is 1 where
  /// it presses and -1 where it pulls.
  Vector direction{};
  bool is_support = false;  ///< fixes, absorbs, or prescribes zero
  double area = 0;          ///< of a pressure: the loaded one [m^2]
};

/// The conditions whose loads add up to that of the testing machine: the one that `[output] governing` names,
/// or else the one that drives the body, with all of its name. What drives is the first that changes with
/// time, or else the first that prescribes anything but zero. Empty where nothing does.
///
/// A condition's direction is that of its rate, of a velocity or without a rate that of its value, turned
/// round where the first non-zero factor of its history is negative.
std::vector<GoverningCondition> governing_conditions(const input::Parameters& parameters);

}  // namespace crackle::mechanics
