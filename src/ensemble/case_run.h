// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"
#include "crackle/ensemble/ensemble_run.h"
#include "crackle/ensemble/folder_lock.h"
#include "crackle/ensemble/group_layout.h"
#include "crackle/ensemble/progress.h"
#include "crackle/ensemble/run_log.h"
#include "crackle/ensemble/sample_plan.h"
#include "crackle/ensemble/sample_schedule.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

/// The run of one ensemble, in steps, so that a sweep can interleave its cases.
namespace crackle::ensemble {

/// Seconds of a steady clock.
double seconds_now();

/// State of the run on the master, rank 0.
struct MasterState {
  SamplePlan plan;
  std::optional<FolderLock> lock;
  std::optional<Progress> progress;
  std::set<std::uint64_t> pending;                // subset of the samples to do
  int n_warnings = 0;                             // over samples done in this run or an earlier one
  const input::Parameters* parameters = nullptr;  // set by prepare_run()
  bool has_warned_of_fast_loading = false;
  /// Failures not recorded in any sample file; completes the rows of the results.
  std::map<std::uint64_t, analysis::SampleSummary> unstored;
};

/// Locks the samples and plans the run, on rank 0. If the folder does not exist yet, only plans: an input
/// that is rejected later must not create it.
/// @throws std::runtime_error as FolderLock and check_folder
void plan_run(const input::Parameters& parameters, const RunOptions& options, MasterState& master);

/// Creates and locks a folder that plan_run() has only planned, and plans again, since another run may have
/// used it in between. On rank 0.
/// @throws as plan_run
void lock_run(const input::Parameters& parameters, const RunOptions& options, MasterState& master);

/// Writes the initial files of the folder, on rank 0.
/// @pre the samples are locked
/// @param log may be null
/// @throws std::runtime_error naming what cannot be written
void prepare_run(const input::Parameters& parameters, const RunOptions& options, const GroupLayout& layout,
                 MasterState& master, RunLog* log);

/// Shares rank 0's lock with all ranks; empty if it has none. Collective.
LockMark share_mark(const parallel::Communicator& world, const std::optional<FolderLock>& lock);

/// Adds the loss of the folder, detected on rank 0, to `request`.
StopRequest with_loss(const parallel::Communicator& world, StopRequest request, const LockMark& mark);

/// Why the folder can no longer be written, on rank 0; empty while it is the locked one.
std::string loss(const std::optional<FolderLock>& lock);

/// The same steps, which write files only while the folder is the locked one.
SampleSteps guarded(SampleSteps steps, const LockMark& mark);

/// The master's callbacks for a case. The references must outlive the events.
/// @param log may be null
ScheduleEvents make_events(MasterState& master, RunLog* log);

/// Sends the shared points from the master to the roots of the groups, which make the meshes. Collective.
void share_base(const parallel::Communicator& world, const GroupLayout& layout, geometry::MotherPoints& base);

/// Writes ensemble.h5, unless the run is of a range of samples or the folder is lost, and logs how the run
/// ended. Collective.
/// @param log null on ranks other than the root, and for silent runs
/// @param seconds taken by the run
RunOutcome finish_run(const parallel::Communicator& world, const input::Parameters& parameters,
                      const RunOptions& options, const MasterState& master,
                      const geometry::MotherPoints& base, bool is_stopping, RunLog* log, double seconds);

}  // namespace crackle::ensemble
