// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/breaking_check.h"

#include "crackle/fracture/principal_stress.h"

#include <algorithm>
#include <iterator>

namespace crackle::dynamics {

double BreakingCheck::largest_principal(const mechanics::Symmetric& strain) const {
  return fracture::largest_principal(body_->elasticity()(strain));
}

void BreakingCheck::start() {
  over_.clear();
  for (const auto t : motion_->overloaded())
    if (largest_principal(motion_->strain(t)) > criterion_->strength(static_cast<std::size_t>(t)))
      over_.push_back(t);
}

void BreakingCheck::end_step(double load_time, double phase_time) {
  // One whose stress has fallen was above the strength for a part of the step.
  candidates_.clear();
  std::ranges::set_union(over_, motion_->overloaded(), std::back_inserter(candidates_));
  over_.clear();
  for (const auto t : candidates_) {
    const auto number = static_cast<std::size_t>(t);
    const mechanics::Symmetric strain = motion_->strain(t);
    const double earlier = largest_principal(motion_->strain_before(t, 2));
    const double before = largest_principal(motion_->strain_before(t, 1));
    const double after = largest_principal(strain);
    if (criterion_->advance(number, earlier, before, after))
      body_->release(t, strain, load_time, phase_time);
    else if (after > criterion_->strength(number))
      over_.push_back(t);
  }
}

}  // namespace crackle::dynamics
