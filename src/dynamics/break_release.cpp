// SPDX-License-Identifier: GPL-3.0-or-later
#include "break_release.h"

#include "dynamics/checkpoint.h"

namespace crackle::dynamics {

std::span<const std::int32_t> BreakRelease::apply(std::span<const std::int32_t> breaking, double phase_time,
                                                  StepFailure& failure) {
  fracture::BreakableBody& body = *context_.body;
  const std::size_t n_changes = body.changes().size();
  failure.guard([&] {
    const auto strain = [&](std::int32_t t) { return motion_->strain(t); };
    if (body.is_releasing()) body.continue_releases(phase_time, strain);
    for (const auto t : breaking) body.release(t, strain(t), load_time_, phase_time, true);
  });
  failure.guard_messages([&] {
    body.release_bridges(*context_.group, load_time_, phase_time,
                         [&](std::int32_t t) { return motion_->strain(t); });
  });
  const auto changes = body.changes().subspan(n_changes);
  if (!changes.empty())
    failure.guard([&] {
      context_.law->take_over(body, changes);
      motion_->release(changes);
    });
  failure.guard_messages([&] { update_strengths(phase_time); });
  return changes;
}

void BreakRelease::restore(const fracture::Releases& releases, double phase_time) {
  motion_->release(context_.law->restore(releases, *context_.body, phase_time));
}

void BreakRelease::update_strengths(double phase_time) {
  motion_->update_strengths(context_.law->follow_cracks(*context_.group, phase_time));
}

}  // namespace crackle::dynamics
