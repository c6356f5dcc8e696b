// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sweep_run.h"

#include "crackle/common/failure.h"
#include "crackle/common/index.h"
#include "crackle/common/regular_file.h"
#include "crackle/common/whole_number.h"
#include "crackle/dynamics/model_limits.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/memory.h"
#include "crackle/ensemble/results.h"
#include "crackle/io/sample_file.h"
#include "crackle/io/text_file.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include "case_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <mutex>
#include <numeric>
#include <ostream>
#include <set>

namespace crackle::ensemble {

namespace fs = std::filesystem;

namespace {

/// The input lines that determine the base mother points or, with `of_mesh`, the realizations.
std::string mesh_settings(const input::Parameters& parameters, bool of_mesh) {
  std::string settings = parameters.mesh.points_digest;
  for (const std::string& line : input::body_settings(parameters)) {
    const bool of_realization = line.starts_with("mesh.perturbation") || line.starts_with("mesh.symmetry");
    if (of_mesh || !of_realization) settings += line + "\n";
  }
  for (const std::string& line : input::sample_settings(parameters)) {
    // With random geometry, meshes differ between draws, and the sampling plan determines the draws.
    const bool is_random = of_mesh && !parameters.random.empty() &&
                           (line.starts_with("random[") || line.starts_with("ensemble."));
    if (is_random || line.starts_with("ensemble.seed")) settings += line + "\n";
  }
  return settings;
}

/// Base mother points, made once for all cases with the same ones.
class SharedBases {
public:
  geometry::MotherPoints& of(const input::Parameters& parameters) {
    return bases_[mesh_settings(parameters, false)];
  }
  auto begin() { return bases_.begin(); }
  auto end() { return bases_.end(); }

private:
  std::map<std::string, geometry::MotherPoints> bases_;
};

/// Caches the last realization, for the next case with the same body.
class LastRealization {
public:
  geometry::Realization of(const std::string& settings, std::uint64_t sample, const RealizationMaker& make) {
    const std::lock_guard lock(mutex_);
    if (!realization_ || sample != sample_ || settings != settings_) {
      realization_.reset();
      realization_ = make(sample);
      settings_ = settings;
      sample_ = sample;
    }
    return *realization_;
  }

private:
  std::mutex mutex_;
  std::string settings_;
  std::uint64_t sample_ = 0;
  std::optional<geometry::Realization> realization_;
};

/// One case on every rank; plan, lock, progress and log are the root's.
struct RunningCase {
  const input::Case* of;
  RunOptions options;
  std::unique_ptr<const geometry::Body> body;
  MasterState master;
  std::string mesh;  ///< mesh_settings of realizations
  SampleSteps steps;
  std::unique_ptr<RunLog> log;
  ScheduleEvents events;

  const input::Parameters& parameters() const { return of->parameters; }
};

/// Numbers the samples of all cases; equal sample numbers of different cases are adjacent.
struct Numbering {
  std::size_t n_cases;

  std::uint64_t number(std::size_t of_case, std::uint64_t sample) const { return sample * n_cases + of_case; }
  std::size_t case_of(std::uint64_t number) const { return number % n_cases; }
  std::uint64_t sample_of(std::uint64_t number) const { return number / n_cases; }
};

/// Forwards each step to the sample's case.
SampleSteps dispatched(std::deque<RunningCase>& cases, const Numbering& numbering,
                       const std::shared_ptr<LastRealization>& last) {
  const auto at = [&cases, numbering](std::uint64_t number) -> RunningCase& {
    return cases[numbering.case_of(number)];
  };
  SampleSteps steps;
  steps.make = [=](std::uint64_t number) {
    const RunningCase& one = at(number);
    return last->of(one.mesh, numbering.sample_of(number), one.steps.make);
  };
  steps.split = [=](std::uint64_t number, const geometry::Realization& realization, int n_parts) {
    return at(number).steps.split(numbering.sample_of(number), realization, n_parts);
  };
  steps.compute = [=](const parallel::Communicator& group, std::uint64_t number,
                      const geometry::Subdomain& subdomain, const dynamics::SampleControl& control) {
    dynamics::SampleControl own = control;
    own.sample = numbering.sample_of(number);
    return at(number).steps.compute(group, own.sample, subdomain, own);
  };
  steps.analyse = [=](std::uint64_t number, const geometry::Realization& realization,
                      const dynamics::SampleResult& result) {
    return at(number).steps.analyse(numbering.sample_of(number), realization, result);
  };
  steps.write = [=](std::uint64_t number, const geometry::Realization& realization,
                    const dynamics::SampleResult& result, const SampleAnalysis& analysis) {
    at(number).steps.write(numbering.sample_of(number), realization, result, analysis);
  };
  steps.write_failure = [=](std::uint64_t number, const analysis::SampleSummary& failure,
                            const PartialSample* partial) {
    at(number).steps.write_failure(numbering.sample_of(number), failure, partial);
  };
  steps.failure_row = [=](std::uint64_t number, const std::string& reason) {
    return at(number).steps.failure_row(numbering.sample_of(number), reason);
  };
  steps.read_checkpoint = [=](std::uint64_t number) {
    return at(number).steps.read_checkpoint(numbering.sample_of(number));
  };
  steps.write_checkpoint = [=](std::uint64_t number, std::span<const std::byte> checkpoint) {
    at(number).steps.write_checkpoint(numbering.sample_of(number), checkpoint);
  };
  steps.remove_checkpoint = [=](std::uint64_t number) {
    at(number).steps.remove_checkpoint(numbering.sample_of(number));
  };
  return steps;
}

/// One progress line for all cases.
class SweepProgress {
public:
  SweepProgress(std::deque<RunningCase>& cases, int n_groups) : cases_(cases), n_groups_(n_groups) {}

  void ended(double seconds) {
    seconds_ += seconds;
    ++n_ended_;
  }
  std::string line() const {
    int n_done = 0, n_failed = 0, n_running = 0, n_left = 0;
    for (const RunningCase& one : cases_) {
      n_done += one.master.progress->n_done();
      n_failed += one.master.progress->n_failed();
      n_running += one.master.progress->n_running();
      n_left += one.master.progress->n_left();
    }
    std::string text = fmt::format("{} cases: {} done, {} failed, {} running, {} left", cases_.size(), n_done,
                                   n_failed, n_running, n_left);
    const int n_to_end = n_running + n_left;
    if (n_ended_ > 0 && n_to_end > 0)
      text += fmt::format(", {} to go", format_duration(seconds_ / n_ended_ * n_to_end / n_groups_));
    return text;
  }

private:
  std::deque<RunningCase>& cases_;
  int n_groups_;
  double seconds_ = 0;
  int n_ended_ = 0;
};

ScheduleEvents dispatched_events(std::deque<RunningCase>& cases, const Numbering& numbering,
                                 SweepProgress& progress, RunLog* log) {
  const auto own = [numbering](SampleReport report) {
    report.sample = numbering.sample_of(report.sample);
    return report;
  };
  const auto say = [log, numbering](std::uint64_t number, const std::string& text) {
    if (log != nullptr) log->line(fmt::format("case {}, {}", numbering.case_of(number), text));
  };
  const auto show = [&progress, log](bool news) {
    if (log != nullptr) log->show([&progress] { return progress.line(); }, news);
  };
  const auto is_enough = [](const RunningCase& one) {
    return one.master.progress->statistics().stopped_at().has_value();
  };
  ScheduleEvents events;
  events.is_needed = [&cases, numbering, is_enough](std::uint64_t number) {
    return !is_enough(cases[numbering.case_of(number)]);
  };
  events.started = [&cases, numbering, show](std::uint64_t number) {
    cases[numbering.case_of(number)].events.started(numbering.sample_of(number));
    show(true);
  };
  events.finished = [&cases, &progress, numbering, own, say, show](const SampleReport& report) {
    progress.ended(report.seconds);
    cases[numbering.case_of(report.sample)].events.finished(own(report));
    say(report.sample, describe(own(report)));
    show(true);
  };
  events.parked = [&cases, numbering, own, say](const SampleReport& report) {
    cases[numbering.case_of(report.sample)].events.parked(own(report));
    say(report.sample, describe(own(report)));
  };
  events.tick = [show] { show(false); };
  return events;
}

/// Refuses a folder with other contents or with other cases.
void check_sweep_folder(const fs::path& folder, std::size_t n_cases, bool is_resumed) {
  if (is_taken(folder / "input.toml") || is_taken(results_file(folder)))
    fail("'{}' holds an ensemble; give another folder for a sweep", folder.string());
  require_regular(sweep_input(folder));
  require_regular(sweep_table(folder));
  if (is_taken(sweep_input(folder)) && !is_resumed)
    fail("'{}' holds a sweep already; continue it with --resume, or give another folder", folder.string());
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("case-")) continue;
    const auto number = whole_number<std::size_t>(std::string_view(name).substr(5));
    if (!number || *number >= n_cases || entry.path() != case_folder(folder, *number, n_cases))
      fail("'{}' holds {}, and the sweep has {} cases; give another folder", folder.string(), name, n_cases);
  }
}

}  // namespace

fs::path sweep_input(const fs::path& folder) {
  return folder / "sweep.toml";
}

fs::path sweep_table(const fs::path& folder) {
  return folder / "summary.csv";
}

fs::path case_folder(const fs::path& folder, std::size_t number, std::size_t n_cases) {
  const auto n_digits = std::to_string(n_cases - 1).size();
  return folder / fmt::format("case-{:0{}}", number, n_digits);
}

RunOutcome run_sweep(const parallel::Communicator& outer, const input::Parameters& parameters,
                     const std::vector<input::Case>& given, const RunOptions& options,
                     const std::function<SampleFunction(const input::Parameters&)>& mechanics) {
  const parallel::Communicator world(outer.get());
  const double start = seconds_now();
  std::unique_ptr<RunLog> log;
  if (world.is_root() && options.log != nullptr)
    log = std::make_unique<RunLog>(*options.log, options.terminal_width, seconds_now);
  const auto say = [&log](const std::string& line) {
    if (log) log->line(line);
  };
  const auto layout = parallel::agree(
      world, [&] { return make_group_layout(world.size(), parameters.ensemble.ranks_per_sample); });
  const Numbering numbering{given.size()};
  std::deque<RunningCase> cases;
  SharedBases bases;
  parallel::agree(world, [&] {
    for (std::size_t i = 0; i < given.size(); ++i) {
      RunningCase& one = cases.emplace_back();
      one.of = &given[i];
      one.options = options;
      one.options.folder = case_folder(options.folder, i, given.size());
      one.options.next = {};
      one.body = geometry::make_body(one.parameters());
      one.mesh = mesh_settings(one.parameters(), true);
      bases.of(one.parameters());
    }
  });
  parallel::agree_on_root(world, [&] {
    check_sweep_folder(options.folder, given.size(), options.plan.resume);
    // --resume starts cases that a stopped run had not reached.
    for (RunningCase& one : cases) plan_run(one.parameters(), one.options, one.master);
  });
  for (const RunningCase& one : cases)
    check_memory(world, one.parameters(), *one.body, layout, !one.master.plan.to_do.empty());

  // Each case logs to its own folder only.
  std::ostream nowhere(nullptr);
  std::vector<std::uint64_t> to_do;
  parallel::agree_on_root(world, [&] {
    say(describe(layout));
    if (const auto notice = input::bits_notice(parameters.time.engine); !notice.empty()) say(notice);
    for (const auto& warning : input::sweep_warnings(given)) say("warning: " + warning);
    std::set<std::string> warnings;  // may be common to several cases
    for (std::size_t i = 0; i < cases.size(); ++i) {
      RunningCase& one = cases[i];
      for (const auto& warning : dynamics::model_warnings(one.parameters(), *one.body))
        if (warnings.insert(warning).second) say(fmt::format("warning: case {}: {}", i, warning));
      geometry::MotherPoints& base = bases.of(one.parameters());
      if (base.position.empty() && !one.master.plan.to_do.empty())
        base = make_shared_points(*one.body, one.parameters(), say);
    }
    for (RunningCase& one : cases) lock_run(one.parameters(), one.options, one.master);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      RunningCase& one = cases[i];
      one.log = std::make_unique<RunLog>(nowhere, 0, seconds_now);
      prepare_run(one.parameters(), one.options, layout, one.master, one.log.get());
      one.events = make_events(one.master, one.log.get());
      for (const std::uint64_t sample : one.master.plan.to_do) to_do.push_back(numbering.number(i, sample));
      say(fmt::format("case {}: {}: {} of {} samples to do in {}", i, to_string(one.of->settings),
                      one.master.plan.to_do.size(), one.parameters().ensemble.samples,
                      one.options.folder.string()));
    }
    io::write_text_file(sweep_input(options.folder), parameters.text);
    std::ranges::sort(to_do);
  });
  if (parameters.ensemble.meshes != input::MeshMakers::master)
    for (auto& [settings, base] : bases) share_base(world, layout, base);

  for (RunningCase& one : cases)
    one.steps =
        guarded(make_sample_steps(one.parameters(), *one.body, bases.of(one.parameters()), one.options.folder,
                                  layout.ranks_per_group, mechanics(one.parameters())),
                share_mark(world, one.master.lock));
  StopLatch stop(with_loss(world, options.stop, share_mark(world, cases.front().master.lock)), say);
  SampleSteps steps = dispatched(cases, numbering, std::make_shared<LastRealization>());
  steps.checkpoint_interval = options.checkpoint_interval;
  steps.stop = [&stop] { return stop(); };
  SweepProgress progress(cases, layout.n_groups);
  ScheduleEvents events = dispatched_events(cases, numbering, progress, log.get());
  events.parked = [&, tell = events.parked](const SampleReport& report) {
    if (!stop()) stop.set();
    tell(report);
  };
  events.finished = [&, tell = events.finished](const SampleReport& report) {
    tell(report);
    const auto& lock = cases[numbering.case_of(report.sample)].master.lock;
    if (!report.stored && !loss(lock).empty()) stop.set();
  };
  schedule_samples(world, layout, to_do, steps, events,
                   QueueLimits{.n_realizations = static_cast<std::size_t>(layout.n_groups) + 1},
                   parameters.ensemble.meshes);
  const bool is_stopping = parallel::share(world, stop.is_set());

  RunOutcome all;
  std::vector<CaseRows> rows;  // on the root
  for (std::size_t i = 0; i < cases.size(); ++i) {
    RunningCase& one = cases[i];
    geometry::MotherPoints& base = bases.of(one.parameters());
    // No case with these points had anything to do.
    parallel::agree_on_root(world, [&] {
      if (base.position.empty() && one.parameters().mesh.base == input::Base::shared)
        base = base_points(one.options.folder, one.parameters());
    });
    RunOutcome outcome = finish_run(world, one.parameters(), one.options, one.master, base, is_stopping,
                                    one.log.get(), seconds_now() - start);
    all.done += outcome.done;
    all.failed += outcome.failed;
    all.left += outcome.left;
    all.lost = all.lost || outcome.lost;
    if (!outcome.file_error.empty()) {
      all.file_error = outcome.file_error;
      say(fmt::format("case {}: {} could not be written: {}", i, results_file(one.options.folder).string(),
                      outcome.file_error));
    }
    rows.push_back({one.of, one.options.folder.filename().string(), std::move(outcome.rows)});
  }
  all.stopped = is_stopping && all.left > 0 && !all.lost;
  if (all.lost) return all;
  try {
    parallel::agree_on_root(world, [&] {
      for (std::size_t i = 0; i < cases.size(); ++i) {
        if (!rows[i].rows.empty()) continue;
        const RunningCase& one = cases[i];
        const auto n = static_cast<std::size_t>(one.parameters().ensemble.samples);
        rows[i].rows = io::read_summaries(one.options.folder, one.parameters(), 0, n);
      }
      if (log) log->end_progress();
      say(fmt::format("{} cases: {} done, {} failed, {} pending after {}", cases.size(), all.done, all.failed,
                      all.left, format_duration(seconds_now() - start)));
      if (log && options.log != nullptr) *options.log << sweep_text(rows);
      io::write_text_file(sweep_table(options.folder), sweep_csv(rows));
      say(sweep_table(options.folder).string());
    });
  } catch (const parallel::AgreedError& error) {
    all.file_error = error.what();
    say(fmt::format("{} could not be written: {}", sweep_table(options.folder).string(), all.file_error));
  }
  const bool is_whole = all.left == 0 && all.file_error.empty();
  if (!is_whole && !options.next.resume.empty()) say("to continue: " + options.next.resume);
  if (is_whole && all.failed > 0 && !options.next.retry_failed.empty())
    say("to compute failed samples again: " + options.next.retry_failed);
  return all;
}

}  // namespace crackle::ensemble
