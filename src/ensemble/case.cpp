// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/case.h"

#include "analysis/statistics.h"
#include "common/heartbeat.h"
#include "common/index.h"
#include "common/quantity_text.h"
#include "common/regular_file.h"
#include "common/text_table.h"
#include "dynamics/model_limits.h"
#include "ensemble/base_points.h"
#include "ensemble/results.h"
#include "io/sample_file.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <fmt/format.h>

#include <chrono>
#include <span>
#include <utility>

namespace crackle::ensemble {

using analysis::SampleStatus;
using analysis::SampleSummary;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

namespace {

/// Warnings that a sample left the range in which the model holds, each empty if it did not.
std::array<std::string, 2> limits_passed(const input::Model& model, const SampleReport& report) {
  return {
      dynamics::fast_loading_warning(model.time.start, report.summary.first_break_time, report.wave_transit),
      dynamics::large_displacement_warning(model.time.start, model.specimen.size,
                                           report.summary.displacement_at_peak)};
}

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
RunOutcome share_counts(const parallel::Communicator& world, Counts counts, bool is_stopping) {
  counts = parallel::share(world, counts);
  return {.done = counts[0],
          .failed = counts[1],
          .left = counts[2],
          .stopped = is_stopping && counts[2] > 0,
          .file_error = {}};
}

/// Logs the pending samples, one line per reason.
void log_pending(RunLog& log, std::span<const SampleSummary> rows) {
  std::map<std::string, std::vector<std::uint64_t>> samples;  // by reason
  for (std::size_t sample = 0; sample < rows.size(); ++sample)
    if (rows[sample].status == SampleStatus::pending) samples[rows[sample].error].push_back(sample);
  for (const auto& [reason, list] : samples)
    log.line(fmt::format("pending: {}{}{}", format_samples(list), reason.empty() ? "" : ": ", reason));
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
    log.line("warning: no sample broke under its loads; crackle check shows how close they came");
}

void log_next(RunLog& log, const NextCommands& next, const RunOutcome& outcome, bool has_results) {
  const auto name = [&](const char* action, const std::string& command) {
    if (!command.empty()) log.line(fmt::format("{}: {}", action, command));
  };
  if (outcome.left > 0 || !outcome.file_error.empty()) return name("to continue", next.resume);
  if (outcome.failed > 0) name("to compute failed samples again", next.retry_failed);
  if (outcome.done > 0 && has_results) name("pictures and report", next.report);
}

}  // namespace

void Case::say(const std::string& line) const {
  if (log_ != nullptr) log_->line(line);
}

SamplePlan Case::planned() const {
  if (options_.single) return plan_sample(folder_, parameters_, options_);
  return ensemble::make_plan(folder_, parameters_, options_, summary_reader(parameters_));
}

void Case::make_plan() {
  // Refuses what it must before the lock writes into the folder.
  if (options_.single || !is_taken(folder_))
    plan_ = planned();
  else
    check_folder(folder_, parameters_, options_);
  if (is_taken(folder_)) lock();
}

void Case::lock() {
  if (lock_) return;
  const auto n_samples = static_cast<std::uint64_t>(parameters_.ensemble.samples);
  const SampleRange all{0, n_samples - 1};
  lock_.emplace(folder_, options_.single ? SampleRange{*options_.single, *options_.single}
                                         : options_.range.value_or(all));
  plan_ = planned();
}

void Case::begin(int n_groups, RunLog* log) {
  log_ = log;
  for (const auto& line : lock_->taken_over()) say(line);
  const auto prepared = prepare_folder(folder_, parameters_, plan_);
  if (log != nullptr && !options_.single) log->keep(run_log_file(folder_, options_.range));
  for (const auto& line : prepared) say(line);
  const auto warnings = [&] {
    Heartbeat heartbeat([this](const std::string& line) { say(line); });
    heartbeat.begin("examining the input");
    return dynamics::model_warnings(parameters_, *body_);
  }();
  for (const auto& warning : warnings) say("warning: " + warning);
  progress_.emplace(plan_.to_do.size(), n_groups, parameters_);
  for (const auto& kept : plan_.kept) progress_->kept(kept.sample, kept.summary);
  pending_.insert(plan_.to_do.begin(), plan_.to_do.end());
  if (options_.single) return;
  say(fmt::format("{} of {} samples to compute in {}", plan_.to_do.size(), parameters_.ensemble.samples,
                  folder_.string()));
  if (!plan_.suspended.empty())
    say(fmt::format("{} of them continue from checkpoints", plan_.suspended.size()));
  if (!plan_.anew.empty())
    say(fmt::format("{} of them had failed and are computed again", plan_.anew.size()));
}

void Case::share_mark(const parallel::Communicator& world) {
  const LockMark own = lock_ ? lock_->mark() : LockMark{};
  mark_ = {parallel::share(world, own.file.string()), parallel::share(world, own.text)};
}

std::string Case::loss() const {
  try {
    mark_.require();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

void Case::started(std::uint64_t sample) {
  progress_->started(sample, seconds_now());
  if (log_ != nullptr && !options_.single) log_->show(*progress_, true);
}

void Case::finished(const SampleReport& report) {
  progress_->finished(report, seconds_now());
  pending_.erase(report.sample);
  if (options_.single) {
    single_ = report;
    return;
  }
  if (!report.stored) unstored_[report.sample] = report.summary;
  if (log_ == nullptr) return;
  log_->line(describe(report));
  const auto passed = limits_passed(parameters_, report);
  for (std::size_t i = 0; i < passed.size(); ++i)
    if (!passed[i].empty() && !std::exchange(has_warned_[i], true)) log_->line("warning: " + passed[i]);
  log_->show(*progress_, true);
}

void Case::suspended(const SampleReport& report) {
  progress_->suspended(report.sample);
  if (options_.single)
    single_ = report;
  else
    say(describe(report));
}

void Case::log_end(const RunOutcome& outcome, int n_needed, const NextCommands& next, double seconds) const {
  const auto& rows = outcome.rows;
  const auto needed = std::span(rows).first(static_cast<std::size_t>(n_needed));
  for (std::size_t sample = 0; sample < needed.size(); ++sample)
    if (needed[sample].status == SampleStatus::failed)
      say(fmt::format("failed: sample {}: {}", sample, needed[sample].error));
  log_pending(*log_, needed);
  log_unbroken(*log_, needed);
  if (needed.size() < rows.size())
    say(fmt::format("stopped early: samples 0 to {} suffice, {} were planned", needed.size() - 1,
                    rows.size()));
  say(fmt::format("{} done, {} failed, {} pending after {}", outcome.done, outcome.failed, outcome.left,
                  duration_text(seconds)));
  if (const std::string means = progress_->means(); !means.empty()) say(means);
  const std::filesystem::path file = results_file(folder_);
  say(outcome.file_error.empty() ? file.string() : cannot_write(file, outcome.file_error));
  log_next(*log_, next, outcome, true);
}

void Case::log_end_of_range(const RunOutcome& outcome, const NextCommands& next, double seconds) const {
  const auto enough = progress_->statistics().stopped_at();
  const std::vector<std::uint64_t> pending(pending_.begin(),
                                           enough ? pending_.lower_bound(*enough) : pending_.end());
  if (!pending.empty()) say("pending: " + format_samples(pending));
  say(fmt::format(
      "samples {} to {}: {} done, {} failed, {} pending after {}; merge the parts with crackle stats {}",
      plan_.range.first, plan_.range.last, outcome.done, outcome.failed, outcome.left, duration_text(seconds),
      folder_.string()));
  log_next(*log_, next, outcome, false);
}

/// Restores files needed to resume the run.
void Case::restore_copy() {
  try {
    if (restore_input(folder_, parameters_))
      say(folder_.string() + ": the copy of the input was missing and has been written again");
  } catch (const std::exception& error) {
    say(error.what());
  }
}

RunOutcome Case::finish_single(const parallel::Communicator& world, bool is_stopping,
                               const NextCommands& next) {
  RunOutcome outcome = share_counts(world, counts_of(progress_), is_stopping);
  if (!world.is_root()) return outcome;
  SampleReport report;
  report.sample = *options_.single;
  if (single_) {
    report = *single_;
  } else if (plan_.kept.empty()) {
    report.suspended = true;  // before it started
  } else {
    say(fmt::format("sample {} is already done; it is kept", report.sample));
    report.summary = plan_.kept.front().summary;
    report.stored = true;
  }
  for (const std::string& passed : limits_passed(parameters_, report))
    if (!passed.empty()) say("warning: " + passed);
  if (log_ != nullptr) log_->end_progress();
  say(describe(report));
  if (report.stored) say(io::sample_path(folder_, report.sample).string());
  if (report.suspended && !next.resume.empty()) say("to continue: " + next.resume);
  outcome.rows = {report.summary};
  return outcome;
}

RunOutcome Case::finish(const parallel::Communicator& world, bool is_stopping, const NextCommands& next,
                        double seconds) {
  if (options_.single) return finish_single(world, is_stopping, next);
  const std::string lost = parallel::share(world, world.is_root() ? loss() : std::string());
  if (log_ != nullptr && (!lost.empty() || options_.range)) log_->end_progress();
  if (!lost.empty()) {
    RunOutcome outcome = share_counts(world, counts_of(progress_), false);
    outcome.lost = true;
    outcome.file_error = lost;
    say(fmt::format("{} done, {} failed, {} pending after {}; nothing more was written: {}", outcome.done,
                    outcome.failed, outcome.left, duration_text(seconds), lost));
    return outcome;
  }
  if (world.is_root()) restore_copy();
  if (options_.range) {
    const RunOutcome outcome = share_counts(world, counts_of(progress_), is_stopping);
    if (log_ != nullptr) log_end_of_range(outcome, next, seconds);
    return outcome;
  }
  RunOutcome outcome;
  Results results;
  geometry::MotherPoints stored;
  const auto base = [&]() -> const geometry::MotherPoints& {
    if (base_->size() > 0) return *base_;
    return stored = base_points(folder_, parameters_);  // there was nothing to do
  };
  try {
    results = write_results(world, parameters_, folder_, unstored_, base);
    outcome = share_counts(world, world.is_root() ? counts_of(results) : Counts{}, is_stopping);
    outcome.file_error = results.file_error;
    if (world.is_root() && outcome.file_error.empty())
      remove_surplus_files(results.statistics, plan_, folder_);
  } catch (const parallel::AgreedError& error) {
    outcome = share_counts(world, counts_of(progress_), is_stopping);
    outcome.file_error = error.what();
  }
  outcome.rows = std::move(results.rows);
  if (log_ == nullptr) return outcome;
  log_->end_progress();
  log_end(outcome, results.statistics.n_needed, next, seconds);
  return outcome;
}

}  // namespace crackle::ensemble
