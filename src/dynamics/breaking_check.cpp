// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/breaking_check.h"

#include "averaged_breaking_check.h"
#include "local_breaking_check.h"

namespace crackle::dynamics {

std::unique_ptr<BreakingCheck> make_breaking_check(const MotionContext& context, MovingBody& motion) {
  if (context.law->average() != nullptr) return std::make_unique<AveragedBreakingCheck>(context, motion);
  return std::make_unique<LocalBreakingCheck>(context, motion);
}

}  // namespace crackle::dynamics
