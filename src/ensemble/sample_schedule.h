// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ensemble/group.h"
#include "ensemble/realization_queue.h"
#include "input/parameters.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <vector>

namespace crackle::ensemble {

/// The course of a run as its master sees it; all called on rank 0.
class ScheduleEvents {
public:
  virtual ~ScheduleEvents() = default;

  virtual void started(std::uint64_t sample) = 0;            ///< handed out to a group
  virtual void finished(const SampleReport& report) = 0;     ///< done or failed
  virtual void suspended(const SampleReport& /*report*/) {}  ///< suspended part-way
  virtual void tick() {}                                     ///< periodically while idle
  virtual bool is_enough() const { return false; }           ///< no more samples are needed
  /// False if the sample is no longer needed; it is then not handed out.
  virtual bool is_needed(std::uint64_t /*sample*/) const { return true; }
};

/// Processes `samples`: the master (rank 0) hands them out one at a time to whichever group asks, with a
/// realization made ahead of need, or without one for the root of the group to make. Idle ranks sleep.
/// Returns when all ranks have finished.
///
/// Once the source's `stop` returns true on any rank, no more samples are handed out and those under way are
/// suspended: the master informs the groups, and a group that suspended its sample by itself informs the
/// master. Collective over `world`, which nothing else may use during the call.
/// @param samples to compute, in order; used on rank 0 only
/// @param source its control's `stop` is used on every rank, `progress` on rank 0 only, as `events` are
/// @param makers ranks that use `source.make`: rank 0, the roots of the groups, or both
/// @throws std::runtime_error on a rank whose communication fails; the other ranks are not informed
void schedule_samples(const parallel::Communicator& world, const GroupLayout& layout,
                      const std::vector<std::uint64_t>& samples, SampleSource& source, ScheduleEvents& events,
                      QueueLimits limits, input::MeshMakers makers);

}  // namespace crackle::ensemble
