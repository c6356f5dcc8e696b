// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/stopwatch.h"
#include "crackle/dynamics/sample_run.h"

#include <cstdint>

namespace crackle::dynamics {

/// Reports the progress of a dynamic phase on a group's root: by the sample's status line if there is one,
/// otherwise now and then by a line of its log.
class PhaseProgress {
public:
  /// @param control must outlive the object
  /// @param phase number of the phase, from 1
  /// @param duration of the phase [s]
  /// @param first_time since the start of the phase, at which this run begins [s]
  PhaseProgress(const SampleControl& control, std::int64_t phase, double duration, double first_time)
      : control_(&control), phase_(phase), duration_(duration), first_time_(first_time) {}

  /// @param row of the energy account; rows up to the start of this run are left out
  void report(const EnergyRow& row);

private:
  const SampleControl* control_;
  std::int64_t phase_;
  double duration_, first_time_;
  Stopwatch watch_;
  double last_report_ = 0;  // by the stopwatch [s]
};

}  // namespace crackle::dynamics
