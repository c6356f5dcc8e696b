// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/group_layout.h"
#include "crackle/ensemble/realization_queue.h"
#include "crackle/ensemble/sample_report.h"
#include "crackle/ensemble/sample_task.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace crackle::ensemble {

/// Callbacks of the master about the run; all called on rank 0.
struct ScheduleEvents {
  std::function<void(std::uint64_t sample)> started;         ///< handed out to a group
  std::function<void(const SampleReport& report)> finished;  ///< done or failed
  std::function<void()> tick;                                ///< called periodically while idle
  std::function<bool()> enough;  ///< true when no more samples are needed; may be empty
  /// False if the sample is no longer needed; it is then not handed out. May be empty.
  std::function<bool(std::uint64_t sample)> is_needed = {};
  std::function<void(const SampleReport& report)> parked = {};  ///< stopped part-way; may be empty
};

/// Processes `samples`: the master (rank 0) hands them out one at a time to whichever group asks, with a
/// realization made ahead of need, or without one for the root of the group to make. Idle ranks sleep.
/// Returns when all ranks have finished.
///
/// Once `steps.stop` returns true on any rank, no more samples are handed out and those under way are parked:
/// the master informs the groups, and a group that parked by itself informs the master. Collective over
/// `world`, which nothing else may use during the call.
/// @param samples to compute, in order; used on rank 0 only
/// @param steps `stop` is used on every rank, `progress` on rank 0 only, as `events` are
/// @param makers ranks that use `steps.make`: rank 0, the roots of the groups, or both
/// @throws std::runtime_error on a rank whose communication fails; the other ranks are not informed
void schedule_samples(const parallel::Communicator& world, const GroupLayout& layout,
                      const std::vector<std::uint64_t>& samples, const SampleSteps& steps,
                      const ScheduleEvents& events, QueueLimits limits, input::MeshMakers makers);

}  // namespace crackle::ensemble
