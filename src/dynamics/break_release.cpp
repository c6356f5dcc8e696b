// SPDX-License-Identifier: GPL-3.0-or-later
#include "break_release.h"

#include "crackle/dynamics/checkpoint.h"

namespace crackle::dynamics {

std::span<const std::int32_t> BreakRelease::apply(std::span<const std::int32_t> breaking, double phase_time,
                                                  StepFailure& failure) {
  fracture::BreakableBody& body = *context_.body;
  const std::size_t n_changes = body.changes().size();
  failure.guard([&] {
    for (const auto t : breaking) body.release(t, motion_->strain(t), load_time_, phase_time);
  });
  failure.guard_messages([&] {
    body.release_bridges(*context_.group, load_time_, phase_time,
                         [&](std::int32_t t) { return motion_->strain(t); });
  });
  const auto changes = body.changes().subspan(n_changes);
  if (!changes.empty())
    failure.guard([&] {
      fracture::update_strengths(*context_.criterion, body, changes);
      motion_->release(changes);
    });
  return changes;
}

void BreakRelease::restore(const fracture::Releases& releases) {
  motion_->release(restore_releases(releases, *context_.body, *context_.criterion));
}

}  // namespace crackle::dynamics
