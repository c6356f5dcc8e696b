// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/breaking_check.h"

#include "averaged_breaking_check.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace crackle::dynamics {

namespace {

/// Check with each tetrahedron's own stress. All ranks that hold a tetrahedron reach the same decision.
class LocalBreakingCheck final : public BreakingCheck {
public:
  LocalBreakingCheck(const MotionContext& context, MovingBody& motion)
      : body_(context.body), motion_(&motion), criterion_(context.criterion) {}

  void start() override {
    over_.clear();
    for (const auto t : motion_->overloaded())
      if (stress(t, motion_->strain(t)) > criterion_->strength(static_cast<std::size_t>(t)))
        over_.push_back(t);
  }

  std::span<const std::int32_t> end_step(std::int64_t) override {
    // A tetrahedron whose stress has dropped was above the strength for part of the step.
    candidates_.clear();
    std::ranges::set_union(over_, motion_->overloaded(), std::back_inserter(candidates_));
    over_.clear();
    breaking_.clear();
    for (const auto t : candidates_) {
      const auto number = static_cast<std::size_t>(t);
      const double earlier = stress(t, motion_->strain_before(t, 2));
      const double before = stress(t, motion_->strain_before(t, 1));
      const double after = stress(t, motion_->strain(t));
      if (criterion_->advance(number, earlier, before, after))
        breaking_.push_back(t);
      else if (after > criterion_->strength(number))
        over_.push_back(t);
    }
    return breaking_;
  }

private:
  double stress(std::int32_t tetrahedron, const mechanics::Symmetric& strain) const {
    return criterion_->stress()(body_->intact_stress(tetrahedron, strain));
  }

  const fracture::BreakableBody* body_;
  MovingBody* motion_;
  fracture::Criterion* criterion_;
  std::vector<std::int32_t> over_;  // above the strength at the end of the last step; unbroken, ascending
  std::vector<std::int32_t> candidates_, breaking_;
};

}  // namespace

std::unique_ptr<BreakingCheck> make_breaking_check(const MotionContext& context, MovingBody& motion) {
  if (context.average != nullptr) return std::make_unique<AveragedBreakingCheck>(context, motion);
  return std::make_unique<LocalBreakingCheck>(context, motion);
}

}  // namespace crackle::dynamics
