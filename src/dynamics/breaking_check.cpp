// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/breaking_check.h"

#include <algorithm>
#include <iterator>

namespace crackle::dynamics {

void BreakingCheck::start() {
  over_.clear();
  for (const auto t : motion_->overloaded())
    if (stress(motion_->strain(t)) > criterion_->strength(static_cast<std::size_t>(t))) over_.push_back(t);
}

std::span<const std::int32_t> BreakingCheck::end_step() {
  // One whose stress has fallen was above the strength for a part of the step.
  candidates_.clear();
  std::ranges::set_union(over_, motion_->overloaded(), std::back_inserter(candidates_));
  over_.clear();
  breaking_.clear();
  for (const auto t : candidates_) {
    const auto number = static_cast<std::size_t>(t);
    const double earlier = stress(motion_->strain_before(t, 2));
    const double before = stress(motion_->strain_before(t, 1));
    const double after = stress(motion_->strain(t));
    if (criterion_->advance(number, earlier, before, after))
      breaking_.push_back(t);
    else if (after > criterion_->strength(number))
      over_.push_back(t);
  }
  return breaking_;
}

}  // namespace crackle::dynamics
