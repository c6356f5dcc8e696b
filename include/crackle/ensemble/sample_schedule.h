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

/// What the master tells about the run; all called on rank 0.
struct ScheduleEvents {
  std::function<void(std::uint64_t sample)> started;         ///< handed out to a group
  std::function<void(const SampleReport& report)> finished;  ///< done or failed
  std::function<void()> tick;                                ///< now and then, while nothing happens
  std::function<bool()> enough;  ///< true when no more samples are needed; may be empty
  /// False for a sample that is not needed any more, and is not handed out; may be empty.
  std::function<bool(std::uint64_t sample)> is_needed = {};
  std::function<void(const SampleReport& report)> parked = {};  ///< stopped on the way; may be empty
};

/// Works off `samples`: the master (rank 0) hands them out, one at a time, to whichever group asks, with the
/// realization that it has made ahead of need, or for the root of the group to make it. Idle ranks sleep.
/// Returns when all ranks have ended.
///
/// As soon as any rank's `steps.stop` says so, no more samples are handed out and those under way are parked:
/// the master tells the groups, and a group that parked by itself tells the master. Collective over `world`,
/// a communicator that nothing else uses meanwhile.
/// @param samples to do, in order of handing out; used on rank 0 only
/// @param steps `stop` is used on every rank, `progress` on rank 0 only, as `events` are
/// @param makers ranks that use `steps.make`: rank 0, the roots of the groups, or both
/// @throws std::runtime_error on a rank whose messages fail, which cannot be agreed on any more
void schedule_samples(const parallel::Communicator& world, const GroupLayout& layout,
                      const std::vector<std::uint64_t>& samples, const SampleSteps& steps,
                      const ScheduleEvents& events, QueueLimits limits, input::MeshMakers makers);

}  // namespace crackle::ensemble
