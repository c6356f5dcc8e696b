// SPDX-License-Identifier: GPL-3.0-or-later
#include "case_run.h"

#include "crackle/analysis/sample_summary.h"
#include "crackle/analysis/statistics.h"
#include "crackle/common/index.h"
#include "crackle/common/regular_file.h"
#include "crackle/common/stopwatch.h"
#include "crackle/dynamics/model_limits.h"
#include "crackle/ensemble/progress.h"
#include "crackle/ensemble/results.h"
#include "crackle/ensemble/run_log.h"
#include "crackle/input/reader.h"
#include "crackle/io/sample_file.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

namespace crackle::ensemble {

namespace {

using analysis::SampleStatus;
using analysis::SampleSummary;

/// Deletes this run's samples that were under way when the ensemble stopped early: which ones depends on
/// scheduling, so they are not part of the ensemble. Samples beyond the stopping point that an earlier run
/// finished stay; readers ignore them, and any that could not be deleted.
void remove_surplus_files(const analysis::Statistics& statistics, const SamplePlan& plan,
                          const std::filesystem::path& folder) {
  std::error_code ignored;
  const auto n_needed = static_cast<std::uint64_t>(statistics.n_needed);
  for (const std::uint64_t sample : plan.to_do)
    if (sample >= n_needed) std::filesystem::remove(io::sample_path(folder, sample), ignored);
}

/// Numbers of samples done, failed and pending.
using Counts = std::array<int, 3>;

Counts counts_of(const std::optional<Progress>& progress) {
  if (!progress) return {};
  return {progress->n_done(), progress->n_failed(), progress->n_left()};
}

/// Counts only samples that are part of the ensemble.
Counts counts_of(const Results& results) {
  Counts counts{};
  for (int i = 0; i < results.statistics.n_needed; ++i) {
    const SampleStatus status = results.rows[index(i)].status;
    ++counts[status == SampleStatus::done ? 0 : status == SampleStatus::failed ? 1 : 2];
  }
  return counts;
}

/// Shares the root's counts with all ranks. Collective.
RunOutcome share_counts(const parallel::Communicator& world, Counts counts) {
  counts = parallel::share(world, counts);
  return {.done = counts[0], .failed = counts[1], .left = counts[2], .stopped = false, .file_error = {}};
}

/// Logs the pending samples, one line per reason.
void log_pending(RunLog& log, std::span<const SampleSummary> rows) {
  std::map<std::string, std::vector<std::uint64_t>> samples;  // by reason
  for (std::size_t sample = 0; sample < rows.size(); ++sample)
    if (rows[sample].status == SampleStatus::pending) samples[rows[sample].error].push_back(sample);
  for (const auto& [reason, list] : samples)
    log.line(fmt::format("pending: {}{}{}", format_samples(list), reason.empty() ? "" : ": ", reason));
}

void log_warnings(RunLog& log, std::size_t n_warnings) {
  if (n_warnings == 0) return;
  log.line(fmt::format("warning: {} with a crack faster than the Rayleigh speed",
                       n_warnings == 1 ? "1 sample" : fmt::format("{} samples", n_warnings)));
}

/// Warns if no sample has broken, which is rarely intended.
void log_unbroken(RunLog& log, std::span<const SampleSummary> rows) {
  std::size_t n_done = 0, n_unbroken = 0;
  for (const SampleSummary& row : rows) {
    if (row.status != SampleStatus::done) continue;
    ++n_done;
    n_unbroken += row.outcome == static_cast<std::int32_t>(dynamics::Outcome::unbroken) ? 1 : 0;
  }
  if (n_done > 0 && n_unbroken == n_done)
    log.line("warning: no sample broke under its loads; crackle check says how close they come");
}

void log_next(RunLog& log, const NextCommands& next, const RunOutcome& outcome, bool has_results) {
  const auto name = [&](const char* what, const std::string& command) {
    if (!command.empty()) log.line(fmt::format("{}: {}", what, command));
  };
  if (outcome.left > 0 || !outcome.file_error.empty()) return name("to continue", next.resume);
  if (outcome.failed > 0) name("to compute failed samples again", next.retry_failed);
  if (outcome.done > 0 && has_results) name("pictures and report", next.report);
}

void log_end(RunLog& log, const Results& results, const Progress& progress, const RunOutcome& outcome,
             const RunOptions& options, double seconds) {
  const auto n_needed = static_cast<std::size_t>(results.statistics.n_needed);
  for (std::size_t sample = 0; sample < n_needed; ++sample) {
    const auto& row = results.rows[sample];
    if (row.status == SampleStatus::failed) log.line(fmt::format("failed: sample {}: {}", sample, row.error));
  }
  const auto needed = std::span(results.rows).first(n_needed);
  log_pending(log, needed);
  log_warnings(log, analysis::sample_warnings(needed).size());
  log_unbroken(log, needed);
  if (n_needed < results.rows.size()) {
    log.line(
        fmt::format("stopped early: samples 0 to {} of {} are enough", n_needed - 1, results.rows.size()));
  }
  log.line(fmt::format("{} done, {} failed, {} pending after {}", outcome.done, outcome.failed, outcome.left,
                       format_duration(seconds)));
  if (const std::string means = progress.means(); !means.empty()) log.line(means);
  const std::string file = results_file(options.folder).string();
  log.line(outcome.file_error.empty() ? file
                                      : fmt::format("{} could not be written: {}", file, outcome.file_error));
  log_next(log, options.next, outcome, true);
}

/// End of the log for a run of a range of samples.
void log_end_of_range(RunLog& log, const MasterState& master, const RunOutcome& outcome,
                      const RunOptions& options, double seconds) {
  log.end_progress();
  const auto enough = master.progress->statistics().stopped_at();
  const std::vector<std::uint64_t> pending(
      master.pending.begin(), enough ? master.pending.lower_bound(*enough) : master.pending.end());
  if (!pending.empty()) log.line("pending: " + format_samples(pending));
  log_warnings(log, static_cast<std::size_t>(master.n_warnings));
  log.line(
      fmt::format("samples {} to {}: {} done, {} failed, {} pending after {}; crackle stats {} merges what "
                  "there is",
                  master.plan.range.first, master.plan.range.last, outcome.done, outcome.failed, outcome.left,
                  format_duration(seconds), options.folder.string()));
  log_next(log, options.next, outcome, false);
}

}  // namespace

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

namespace {

constexpr double look_interval = 10;  // [s] between checks that the folder still exists

SampleRange range_of(const input::Parameters& parameters, const RunOptions& options) {
  const auto n_samples = static_cast<std::uint64_t>(parameters.ensemble.samples);
  return options.plan.range.value_or(SampleRange{0, n_samples - 1});
}

}  // namespace

void plan_run(const input::Parameters& parameters, const RunOptions& options, MasterState& master) {
  if (!is_taken(options.folder)) {
    master.plan = make_plan(options.folder, parameters, options.plan, summary_reader(parameters));
    return;
  }
  check_folder(options.folder, parameters, options.plan);  // before the lock writes into it
  lock_run(parameters, options, master);
}

void lock_run(const input::Parameters& parameters, const RunOptions& options, MasterState& master) {
  if (master.lock) return;
  master.lock.emplace(options.folder, range_of(parameters, options));
  master.plan = make_plan(options.folder, parameters, options.plan, summary_reader(parameters));
}

LockMark share_mark(const parallel::Communicator& world, const std::optional<FolderLock>& lock) {
  const LockMark own = lock ? lock->mark() : LockMark{};
  return {parallel::share(world, own.file.string()), parallel::share(world, own.text)};
}

namespace {

/// Why the lock is lost; empty while it is held.
std::string loss_of(const LockMark& mark) {
  try {
    mark.require();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

}  // namespace

StopRequest with_loss(const parallel::Communicator& world, StopRequest request, const LockMark& mark) {
  if (!world.is_root()) return request;
  return [mark, own = std::move(request), clock = Stopwatch()]() mutable -> std::optional<std::string> {
    if (own)
      if (auto reason = own()) return reason;
    if (clock.seconds() < look_interval) return std::nullopt;
    clock = Stopwatch();
    std::string reason = loss_of(mark);
    return reason.empty() ? std::nullopt : std::optional(std::move(reason));
  };
}

std::string loss(const std::optional<FolderLock>& lock) {
  return lock ? loss_of(lock->mark()) : std::string();
}

SampleSteps guarded(SampleSteps steps, const LockMark& mark) {
  const auto before = [&mark](auto& step) {
    step = [mark, own = std::move(step)](const auto&... arguments) {
      mark.require();
      own(arguments...);
    };
  };
  before(steps.write);
  before(steps.write_failure);
  before(steps.write_checkpoint);
  return steps;
}

void prepare_run(const input::Parameters& parameters, const RunOptions& options, const GroupLayout& layout,
                 MasterState& master, RunLog* log) {
  const auto say = [&](const std::string& text) {
    if (log != nullptr) log->line(text);
  };
  const auto& plan = master.plan;
  for (const auto& line : master.lock->taken_over()) say(line);
  const auto prepared = prepare_folder(options.folder, parameters, plan);
  if (log != nullptr) log->keep(run_log_file(options.folder, options.plan.range));
  for (const auto& line : prepared) say(line);
  master.parameters = &parameters;
  for (const auto& warning : dynamics::model_warnings(parameters, *geometry::make_body(parameters)))
    say("warning: " + warning);
  master.progress.emplace(plan.to_do.size(), layout.n_groups, parameters);
  for (const auto& kept : plan.kept) {
    master.progress->kept(kept.sample, kept.summary);
    master.n_warnings += analysis::sample_warning(kept.sample, kept.summary) ? 1 : 0;
  }
  master.pending.insert(plan.to_do.begin(), plan.to_do.end());
  say(fmt::format("{} of {} samples to do in {}", plan.to_do.size(), parameters.ensemble.samples,
                  options.folder.string()));
  if (!plan.parked.empty()) say(fmt::format("{} of them continue from checkpoints", plan.parked.size()));
  if (!plan.anew.empty())
    say(fmt::format("{} of them failed before and are computed again", plan.anew.size()));
}

ScheduleEvents make_events(MasterState& master, RunLog* log) {
  ScheduleEvents events;
  events.enough = [&master] { return master.progress->statistics().stopped_at().has_value(); };
  events.started = [&master, log](std::uint64_t sample) {
    master.progress->started(sample, seconds_now());
    if (log != nullptr) log->show(*master.progress, true);
  };
  events.finished = [&master, log](const SampleReport& report) {
    master.progress->finished(report, seconds_now());
    if (!report.stored) master.unstored[report.sample] = report.summary;
    master.pending.erase(report.sample);
    const auto warning = analysis::sample_warning(report.sample, report.summary);
    master.n_warnings += warning ? 1 : 0;
    if (log == nullptr) return;
    log->line(describe(report));
    if (warning) log->line(*warning);
    if (const auto fast = dynamics::fast_loading_warning(*master.parameters, report.summary.first_break_time);
        !fast.empty() && !std::exchange(master.has_warned_of_fast_loading, true))
      log->line("warning: " + fast);
    log->show(*master.progress, true);
  };
  events.parked = [&master, log](const SampleReport& report) {
    master.progress->parked(report.sample);
    if (log != nullptr) log->line(describe(report));
  };
  events.tick = [&master, log] {
    if (log != nullptr) log->show(*master.progress, false);
  };
  return events;
}

void share_base(const parallel::Communicator& world, const GroupLayout& layout,
                geometry::MotherPoints& base) {
  const int group = layout.group_of(world.rank());
  const bool makes = world.is_root() || (group >= 0 && layout.root_of(group) == world.rank());
  const parallel::Communicator makers = world.split(makes ? 0 : 1, world.rank());
  std::optional<std::string> error;
  try {
    if (makes) {
      base.position = parallel::share(makers, std::move(base.position));
      base.spacing = parallel::share(makers, std::move(base.spacing));
      base.movable = parallel::share(makers, std::move(base.movable));
    }
  } catch (...) {
    error = parallel::current_error();
  }
  parallel::agree_on_error(world, error);
}

namespace {

/// Restores files needed to resume the run.
void restore_copy(const std::filesystem::path& folder, const input::Parameters& parameters, RunLog* log) {
  std::string line;
  try {
    if (!restore_input(folder, parameters)) return;
    line = folder.string() + ": the copy of the input was gone and is written again";
  } catch (const std::exception& error) {
    line = error.what();
  }
  if (log != nullptr) log->line(line);
}

/// Ends a run whose folder was moved or removed: nothing more can be written.
RunOutcome finish_lost_run(const parallel::Communicator& world, const MasterState& master,
                           const std::string& lost, RunLog* log, double seconds) {
  RunOutcome outcome = share_counts(world, counts_of(master.progress));
  outcome.lost = true;
  outcome.file_error = lost;
  if (log == nullptr) return outcome;
  log->end_progress();
  log->line(fmt::format("{} done, {} failed, {} pending after {}; nothing more was written: {}", outcome.done,
                        outcome.failed, outcome.left, format_duration(seconds), lost));
  return outcome;
}

}  // namespace

RunOutcome finish_run(const parallel::Communicator& world, const input::Parameters& parameters,
                      const RunOptions& options, const MasterState& master,
                      const geometry::MotherPoints& base, bool is_stopping, RunLog* log, double seconds) {
  const std::string lost = parallel::share(world, loss(master.lock));
  if (!lost.empty()) return finish_lost_run(world, master, lost, log, seconds);
  RunOutcome outcome;
  Results results;
  if (world.is_root()) restore_copy(options.folder, parameters, log);
  if (options.plan.range) {
    outcome = share_counts(world, counts_of(master.progress));
    outcome.stopped = is_stopping && outcome.left > 0;
    if (log != nullptr) log_end_of_range(*log, master, outcome, options, seconds);
    return outcome;
  }
  try {
    results = write_results(world, parameters, options.folder, master.unstored,
                            [&base]() -> const geometry::MotherPoints& { return base; });
    outcome = share_counts(world, world.is_root() ? counts_of(results) : Counts{});
    outcome.file_error = results.file_error;
    if (world.is_root() && outcome.file_error.empty())
      remove_surplus_files(results.statistics, master.plan, options.folder);
  } catch (const parallel::AgreedError& error) {
    outcome = share_counts(world, counts_of(master.progress));
    outcome.file_error = error.what();
  }
  outcome.stopped = is_stopping && outcome.left > 0;
  if (log != nullptr) {
    log->end_progress();
    log_end(*log, results, *master.progress, outcome, options, seconds);
  }
  outcome.rows = std::move(results.rows);
  return outcome;
}

}  // namespace crackle::ensemble
