// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "ensemble/folder_lock.h"
#include "ensemble/group.h"
#include "ensemble/progress.h"
#include "ensemble/run_log.h"
#include "ensemble/sample_plan.h"
#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "input/parameters.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

/// One ensemble: its input, its folder, and the course of a run.
namespace crackle::ensemble {

/// The mechanics of one sample, normally dynamics::run_sample; a parameter so that tests can inject faults.
/// Collective over the group, as SampleSteps::compute.
/// @param model with the values of the sample's draw
/// @param control with the number of the sample
using Mechanics = std::function<dynamics::SampleResult(
    const parallel::Communicator& group, const input::Model& model, const input::Output& output,
    const geometry::Subdomain& subdomain, const dynamics::SampleControl& control)>;

/// Commands suggested at the end of the log.
struct NextCommands {
  std::string resume;        ///< continues with pending samples
  std::string retry_failed;  ///< recomputes failed ones
  std::string report;        ///< makes figures and a report from the available results
};

/// The same on every rank.
struct RunOutcome {
  int done = 0;
  int failed = 0;
  int left = 0;            ///< pending
  bool stopped = false;    ///< on request, with samples left
  bool lost = false;       ///< the folder was moved or removed during the run
  std::string file_error;  ///< why ensemble.h5 could not be written; empty on success
  /// On the root, as in ensemble.h5; of a single sample, its row; empty for a run of a range.
  std::vector<analysis::SampleSummary> rows = {};
};

/// Seconds of a steady clock.
double seconds_now();

/// Its functions are called in the order of their declaration; those without `world` on rank 0 only.
class Case {
public:
  /// @param parameters must outlive the case
  /// @param base points shared by the samples, available when the first one is made; unused with
  ///   mesh.base = "own"
  /// @param folder, options of a case that is run
  Case(const input::Parameters& parameters, std::shared_ptr<const geometry::Body> body,
       std::shared_ptr<const geometry::MotherPoints> base, Mechanics mechanics,
       std::filesystem::path folder = {}, const PlanOptions& options = {})
      : parameters_(parameters),
        body_(std::move(body)),
        base_(std::move(base)),
        mechanics_(std::move(mechanics)),
        folder_(std::move(folder)),
        options_(options) {}

  const input::Parameters& parameters() const { return parameters_; }
  const geometry::Body& body() const { return *body_; }
  const geometry::MotherPoints& base() const { return *base_; }
  const Mechanics& mechanics() const { return mechanics_; }
  const std::filesystem::path& folder() const { return folder_; }
  const SamplePlan& plan() const { return plan_; }
  const Progress& progress() const { return *progress_; }  ///< after begin()
  const LockMark& mark() const { return mark_; }           ///< on every rank, after share_mark()
  bool is_enough() const { return progress_->statistics().stopped_at().has_value(); }

  /// Locks the samples and plans the run. If the folder does not exist yet, only plans: an input that is
  /// rejected later must not create it.
  /// @throws std::runtime_error as FolderLock, check_folder and plan_sample
  void make_plan();
  /// Creates and locks a folder that make_plan() has only planned, and plans again, since another run may
  /// have used it in between.
  /// @throws as make_plan
  void lock();
  /// Writes the initial files of the folder.
  /// @param log may be null
  /// @throws std::runtime_error naming what cannot be written
  void begin(int n_groups, RunLog* log);
  /// Shares rank 0's lock with all ranks. Collective.
  void share_mark(const parallel::Communicator& world);
  /// Why the folder can no longer be written; empty while it is the locked one.
  std::string loss() const;

  void started(std::uint64_t sample);
  void at_work(const std::string& where) { progress_->at_work(where); }
  void finished(const SampleReport& report);
  void suspended(const SampleReport& report);

  /// Writes ensemble.h5, unless the run is of a range of samples or the folder is lost, and logs how the run
  /// ended. Collective.
  /// @param seconds taken by the run
  RunOutcome finish(const parallel::Communicator& world, bool is_stopping, const NextCommands& next,
                    double seconds);

private:
  void say(const std::string& line) const;
  SamplePlan planned() const;
  void restore_copy();
  RunOutcome finish_single(const parallel::Communicator& world, bool is_stopping, const NextCommands& next);
  void log_end(const RunOutcome& outcome, int n_needed, const NextCommands& next, double seconds) const;
  void log_end_of_range(const RunOutcome& outcome, const NextCommands& next, double seconds) const;

  const input::Parameters& parameters_;
  std::shared_ptr<const geometry::Body> body_;
  std::shared_ptr<const geometry::MotherPoints> base_;
  Mechanics mechanics_;
  std::filesystem::path folder_;
  PlanOptions options_;
  LockMark mark_;

  // On rank 0.
  SamplePlan plan_;
  std::optional<FolderLock> lock_;
  RunLog* log_ = nullptr;
  std::optional<Progress> progress_;
  std::set<std::uint64_t> pending_;   ///< subset of the samples to compute
  std::array<bool, 2> has_warned_{};  ///< of limits_passed()
  /// Failures not recorded in any sample file; completes the rows of the results.
  std::map<std::uint64_t, analysis::SampleSummary> unstored_;
  std::optional<SampleReport> single_;  ///< of a run of a single sample
};

}  // namespace crackle::ensemble
