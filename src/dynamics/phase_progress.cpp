// SPDX-License-Identifier: GPL-3.0-or-later
#include "phase_progress.h"

#include <fmt/format.h>

namespace crackle::dynamics {

namespace {

/// Seconds between two lines of the log.
constexpr double report_interval = 20;

}  // namespace

void PhaseProgress::report(const EnergyRow& row) {
  if (!(row.time > first_time_)) return;
  const double seconds = watch_.seconds();
  const bool is_due = seconds >= last_report_ + report_interval;
  const SampleLog& log = control_->progress ? control_->progress : control_->log;
  if (!log || (!control_->progress && !is_due)) return;
  last_report_ = seconds;
  log(fmt::format(
      "dynamic phase {}: {:.0f} %, {:.1f} of {:.1f} us, {} tetrahedra broken, {:.0f} s left at most", phase_,
      100 * row.time / duration_, 1e6 * row.time, 1e6 * duration_, row.broken,
      seconds * (duration_ - row.time) / (row.time - first_time_)));
}

}  // namespace crackle::dynamics
