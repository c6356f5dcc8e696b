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

/// The run of one ensemble, in the steps that a sweep takes with each of its cases.
namespace crackle::ensemble {

/// Seconds of a steady clock.
double seconds_now();

/// What the master knows of the run, on rank 0.
struct MasterState {
  SamplePlan plan;
  std::optional<FolderLock> lock;
  std::optional<Progress> progress;
  std::set<std::uint64_t> pending;                // of those to do
  int n_warnings = 0;                             // of samples that this run or an earlier one has done
  const input::Parameters* parameters = nullptr;  // from prepare_run() on
  bool has_warned_of_fast_loading = false;
  /// Failures that no sample file tells of; their rows are completed from here.
  std::map<std::uint64_t, analysis::SampleSummary> unstored;
};

/// Locks the samples and plans the run, on rank 0. A folder that is not there yet is planned only: an input
/// that is refused for another reason must not make it.
/// @throws std::runtime_error as FolderLock and check_folder
void plan_run(const input::Parameters& parameters, const RunOptions& options, MasterState& master);

/// Locks what plan_run() has only planned, in a folder that is made now, and plans it anew: another run may
/// have come and gone meanwhile. On rank 0.
/// @throws as plan_run
void lock_run(const input::Parameters& parameters, const RunOptions& options, MasterState& master);

/// Fills the folder, on rank 0.
/// @pre the samples are locked
/// @param log may be null
/// @throws std::runtime_error naming what cannot be written
void prepare_run(const input::Parameters& parameters, const RunOptions& options, const GroupLayout& layout,
                 MasterState& master, RunLog* log);

/// The lock of rank 0 on every rank; empty without one there. Collective.
LockMark share_mark(const parallel::Communicator& world, const std::optional<FolderLock>& lock);

/// `request`, and on rank 0 the folder's loss.
StopRequest with_loss(const parallel::Communicator& world, StopRequest request, const LockMark& mark);

/// Why nothing can be written into the folder any more, on rank 0; empty while it is the locked one.
std::string loss(const std::optional<FolderLock>& lock);

/// The same steps, whose files are written while the folder is the locked one only.
SampleSteps guarded(SampleSteps steps, const LockMark& mark);

/// What the master does when something happens to a sample. The references must outlive the events.
/// @param log may be null
ScheduleEvents make_events(MasterState& master, RunLog* log);

/// The points that all samples share, from the master to the roots of the groups, which make meshes of them.
/// Collective.
void share_base(const parallel::Communicator& world, const GroupLayout& layout, geometry::MotherPoints& base);

/// Writes ensemble.h5, unless the run is of a range of samples or the folder is lost, and says how the run
/// ended. Collective.
/// @param log null on other ranks than the root, and where nothing is said
/// @param seconds that the run has taken
RunOutcome finish_run(const parallel::Communicator& world, const input::Parameters& parameters,
                      const RunOptions& options, const MasterState& master,
                      const geometry::MotherPoints& base, bool is_stopping, RunLog* log, double seconds);

}  // namespace crackle::ensemble
