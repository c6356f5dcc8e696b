// SPDX-License-Identifier: GPL-3.0-or-later
#include "break_release.h"

#include "crackle/dynamics/checkpoint.h"

#include <algorithm>

namespace crackle::dynamics {

std::span<const std::int32_t> BreakRelease::apply(std::span<const std::int32_t> breaking, double phase_time,
                                                  StepFailure& failure) {
  fracture::BreakableBody& body = *context_.body;
  const std::size_t n_changes = body.changes().size();
  failure.guard([&] {
    const auto strain = [&](std::int32_t t) { return motion_->strain(t); };
    if (body.is_releasing())
      body.continue_releases(
          [&](std::int32_t t, double broke_at) { return remaining(t, phase_time - broke_at); }, strain);
    for (const auto t : breaking) body.release(t, strain(t), load_time_, phase_time, remaining(t, 0));
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
  failure.guard_messages([&] { update_strengths(phase_time); });
  return changes;
}

void BreakRelease::restore(const fracture::Releases& releases, double phase_time) {
  motion_->release(
      restore_releases(releases, *context_.body, *context_.criterion,
                       [&](std::int32_t t, double broke_at) { return remaining(t, phase_time - broke_at); }));
}

void BreakRelease::update_strengths(double phase_time) {
  if (context_.vicinity == nullptr) return;
  motion_->update_strengths(context_.vicinity->update(*context_.group, phase_time));
}

double BreakRelease::remaining(std::int32_t tetrahedron, double since_break) const {
  const double release_time = release_time_ != nullptr ? (*release_time_)[tetrahedron] : 0;
  if (release_time == 0) return 0;
  return std::max(0.0, 1 - (since_break + time_step_ / 2) / release_time);
}

}  // namespace crackle::dynamics
