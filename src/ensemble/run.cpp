// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/run.h"

#include "common/stopwatch.h"
#include "common/text_table.h"
#include "dynamics/model_limits.h"
#include "ensemble/base_points.h"
#include "ensemble/material_map.h"
#include "ensemble/memory.h"
#include "ensemble/point_crew.h"
#include "ensemble/results.h"
#include "ensemble/sample_schedule.h"
#include "ensemble/sweep_table.h"
#include "io/sample_file.h"
#include "io/text_file.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include "case_sample.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <deque>
#include <set>
#include <utility>

namespace crackle::ensemble {

namespace {

constexpr double loss_check_interval = 10;  // [s] between checks that the folder still exists

/// The input lines that determine the base mother points or, with `of_mesh`, the realizations.
std::string mesh_settings(const input::Parameters& parameters, bool of_mesh) {
  using enum input::Affects;
  const auto lines = of_mesh ? input::settings_of(parameters, {draws, body, points, mesh, materials})
                             : input::settings_of(parameters, {body, points});
  return fmt::format("{}", fmt::join(lines, "\n"));
}

/// The last realization made on this rank, for the next case with the same body.
struct LastRealization {
  std::string settings;  ///< mesh_settings
  std::uint64_t sample = 0;
  std::optional<geometry::Realization> realization;
};

/// Sends the shared points from the master to the roots of the groups, which make the meshes. Collective.
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

/// A run, on every rank. Its samples are those of all cases, numbered so that equal samples of different
/// cases are adjacent. The steps are the functions in the order of their declaration, all collective.
class Run final : private SampleSource, private ScheduleEvents {
public:
  Run(const parallel::Communicator& outer, const input::Parameters& parameters,
      const std::vector<input::Case>& cases, const RunOptions& options, const Mechanics& mechanics);

  /// Refuses what cannot be run. Writes nothing but locks of folders that exist.
  void plan();
  /// Locks and prepares the folders, and places the base points.
  void begin();
  void compute();
  RunOutcome finish();

private:
  bool is_sweep() const { return !given_.empty(); }
  bool is_single() const { return options_.plan.single.has_value(); }
  std::uint64_t number_of(std::size_t i, std::uint64_t sample) const { return sample * cases_.size() + i; }
  Case& case_of(std::uint64_t number) { return cases_[number % cases_.size()]; }
  const Case& case_of(std::uint64_t number) const { return cases_[number % cases_.size()]; }
  std::uint64_t sample_of(std::uint64_t number) const { return number / cases_.size(); }

  void say(const std::string& line) const {
    if (log_) log_->line(line);
  }
  void say_model_warnings(std::size_t i, std::set<std::string>& warnings) const;
  void begin_case(std::size_t i);
  StopRequest stop_or_loss();
  std::string progress_line() const;
  void show(bool is_news) const;
  /// With the number that the sample has in its case.
  SampleReport in_case(SampleReport report) const {
    report.sample = sample_of(report.sample);
    return report;
  }
  void write_table(std::vector<CaseRows> rows, const RunOutcome& all) const;

  // SampleSource
  geometry::Realization make(std::uint64_t number) override;
  std::unique_ptr<SampleSteps> steps(std::uint64_t number) override {
    return std::make_unique<CaseSample>(case_of(number), sample_of(number));
  }
  dynamics::SampleControl control() override;
  void enter(std::uint64_t number, std::string_view stage) override {
    if (options_.enter) options_.enter(sample_of(number), stage);
  }

  // ScheduleEvents
  void started(std::uint64_t number) override;
  void finished(const SampleReport& report) override;
  void suspended(const SampleReport& report) override;
  void tick() override { show(false); }
  bool is_enough() const override { return std::ranges::all_of(cases_, &Case::is_enough); }
  bool is_needed(std::uint64_t number) const override { return !case_of(number).is_enough(); }

  parallel::Communicator world_;
  const double start_ = seconds_now();
  const input::Parameters& parameters_;
  const std::vector<input::Case>& given_;
  const RunOptions& options_;
  GroupLayout layout_;
  std::map<std::string, std::shared_ptr<geometry::MotherPoints>> bases_;  ///< by mesh_settings
  std::deque<Case> cases_;
  std::vector<std::string> meshes_;  ///< of each case: mesh_settings of realizations
  LastRealization last_;
  StopLatch stop_;

  // On rank 0.
  std::unique_ptr<RunLog> log_;
  std::ostream nowhere_{nullptr};  ///< each case of a sweep logs to its own folder only
  std::deque<RunLog> case_logs_;
  std::vector<std::uint64_t> to_do_;  ///< numbers
  double seconds_ = 0;                ///< over the samples that ended in this run
  int n_ended_ = 0;
};

Run::Run(const parallel::Communicator& outer, const input::Parameters& parameters,
         const std::vector<input::Case>& cases, const RunOptions& options, const Mechanics& mechanics)
    : world_(outer.get()), parameters_(parameters), given_(cases), options_(options) {
  if (world_.is_root() && options.log != nullptr)
    log_ = std::make_unique<RunLog>(*options.log, options.terminal_width, seconds_now);
  parallel::agree(world_, [&] {
    layout_ = is_single() ? one_group(world_.size())
                          : make_group_layout(world_.size(), parameters.ensemble.ranks_per_sample);
  });
  parallel::agree(world_, [&] {
    const std::size_t n = is_sweep() ? cases.size() : 1;
    for (std::size_t i = 0; i < n; ++i) {
      const input::Parameters& own = is_sweep() ? cases[i].parameters : parameters;
      auto& base = bases_[mesh_settings(own, false)];
      if (!base) base = std::make_shared<geometry::MotherPoints>();
      meshes_.push_back(mesh_settings(own, true));
      cases_.emplace_back(own, geometry::make_body(own), base, mechanics,
                          is_sweep() ? case_folder(options.folder, i, n) : options.folder, options.plan);
    }
  });
}

void Run::plan() {
  parallel::agree_on_root(world_, [&] {
    if (is_sweep()) check_sweep_folder(options_.folder, cases_.size(), options_.plan.resume);
    // --resume starts cases that a stopped run had not reached.
    for (Case& one : cases_) {
      check_material_map(one.parameters().map, one.body());
      one.make_plan();
    }
  });
  for (const Case& one : cases_)
    check_memory(world_, one.parameters(), one.body(), layout_, !one.plan().to_do.empty());
}

/// The warnings about a case of a sweep that no other case has had.
void Run::say_model_warnings(std::size_t i, std::set<std::string>& warnings) const {
  for (const auto& warning : dynamics::model_warnings(cases_[i].parameters(), cases_[i].body()))
    if (warnings.insert(warning).second) say(fmt::format("warning: case {}: {}", i, warning));
}

void Run::begin_case(std::size_t i) {
  Case& one = cases_[i];
  one.begin(layout_.n_groups, is_sweep() ? &case_logs_.emplace_back(nowhere_, 0, seconds_now) : log_.get());
  for (const std::uint64_t sample : one.plan().to_do) to_do_.push_back(number_of(i, sample));
  if (is_sweep())
    say(fmt::format("case {}: {}: {} of {} samples to compute in {}", i, to_string(given_[i].settings),
                    one.plan().to_do.size(), one.parameters().ensemble.samples, one.folder().string()));
}

void Run::begin() {
  PointCrew crew(world_, most_placing);
  const auto help = [&](const PointTask& task, std::vector<input::MeshRegion> regions) {
    const Case& one = cases_[task.subject];
    input::Mesh mesh = one.parameters().mesh;
    mesh.regions = std::move(regions);
    geometry::help_mother_points(one.body(), mesh, one.parameters().seed, 0, 0, crew);
  };
  const auto prepare = [&] {
    if (!is_single()) say(describe(layout_));
    if (const auto notice = input::bits_notice(parameters_.time.engine); !notice.empty()) say(notice);
    for (const auto& warning : input::sweep_warnings(given_)) say("warning: " + warning);
    std::set<std::string> warnings;
    for (std::size_t i = 0; i < cases_.size(); ++i) {
      if (is_sweep()) say_model_warnings(i, warnings);
      const Case& one = cases_[i];
      geometry::MotherPoints& base = *bases_[mesh_settings(one.parameters(), false)];
      if (base.size() == 0 && !one.plan().to_do.empty())
        base = make_shared_points(
            one.body(), one.parameters().mesh, one.parameters().seed, [this](const auto& line) { say(line); },
            crew.for_task({.subject = i}));
    }
    for (Case& one : cases_) one.lock();
    for (std::size_t i = 0; i < cases_.size(); ++i) begin_case(i);
    if (is_sweep()) {
      io::write_text_file(sweep_input(options_.folder), parameters_.text);
      if (const auto& solid = parameters_.specimen.solid)
        io::write_text_file(solid_copy(options_.folder, solid->extension), solid->content);
    }
    std::ranges::sort(to_do_);
  };
  crew.agree_on_root(prepare, help);
  if (parameters_.ensemble.meshes != input::MeshMakers::master)
    for (auto& [settings, base] : bases_) share_base(world_, layout_, *base);
  for (Case& one : cases_) one.share_mark(world_);
  stop_ = StopLatch(stop_or_loss(), [this](const std::string& line) { say(line); });
}

/// The request to stop; on the root of an ensemble or sweep also the loss of its folder.
StopRequest Run::stop_or_loss() {
  if (!world_.is_root() || is_single()) return options_.stop;
  return [this, own = options_.stop, clock = Stopwatch()]() mutable -> std::optional<std::string> {
    if (own)
      if (auto reason = own()) return reason;
    if (clock.seconds() < loss_check_interval) return std::nullopt;
    clock = Stopwatch();
    std::string reason = cases_.front().loss();
    return reason.empty() ? std::nullopt : std::optional(std::move(reason));
  };
}

geometry::Realization Run::make(std::uint64_t number) {
  const auto make_new = [&] { return CaseSample(case_of(number), sample_of(number)).make(); };
  if (!is_sweep()) return make_new();
  const std::string& settings = meshes_[number % cases_.size()];
  if (!last_.realization || last_.sample != sample_of(number) || last_.settings != settings) {
    last_.realization.reset();
    last_ = {settings, sample_of(number), make_new()};
  }
  return *last_.realization;
}

dynamics::SampleControl Run::control() {
  dynamics::SampleControl control;
  control.stop = [this] { return stop_(); };
  control.checkpoint_interval = options_.checkpoint_interval;
  if (is_single() && options_.log != nullptr) control.log = [this](const std::string& line) { say(line); };
  if (!log_ || is_sweep() || (is_single() && options_.terminal_width == 0)) return control;
  control.progress = [this](const std::string& where) {
    if (is_single()) return log_->show([&where] { return where; }, false);
    cases_.front().at_work(where);
    show(false);
  };
  return control;
}

/// One line for all cases.
std::string Run::progress_line() const {
  int n_done = 0, n_failed = 0, n_running = 0, n_left = 0;
  for (const Case& one : cases_) {
    n_done += one.progress().n_done();
    n_failed += one.progress().n_failed();
    n_running += one.progress().n_running();
    n_left += one.progress().n_left();
  }
  std::string text = fmt::format("{} cases: {} done, {} failed, {} running, {} pending", cases_.size(),
                                 n_done, n_failed, n_running, n_left);
  const int n_to_end = n_running + n_left;
  if (n_ended_ > 0 && n_to_end > 0)
    text +=
        fmt::format(", about {} remaining", duration_text(seconds_ / n_ended_ * n_to_end / layout_.n_groups));
  return text;
}

void Run::show(bool is_news) const {
  if (!log_ || is_single()) return;
  if (is_sweep())
    log_->show([this] { return progress_line(); }, is_news);
  else
    log_->show(cases_.front().progress(), is_news);
}

void Run::started(std::uint64_t number) {
  case_of(number).started(sample_of(number));
  if (is_sweep()) show(true);
}

void Run::finished(const SampleReport& report) {
  Case& one = case_of(report.sample);
  seconds_ += report.seconds;
  ++n_ended_;
  one.finished(in_case(report));
  if (is_sweep()) {
    say(fmt::format("case {}, {}", report.sample % cases_.size(), describe(in_case(report))));
    show(true);
  }
  // Stop: further samples could not be stored.
  if (!report.stored && !one.loss().empty()) stop_.set();
}

void Run::suspended(const SampleReport& report) {
  // A signal sent to all ranks may reach the group first; poll here too, so that the log names it.
  if (!stop_()) {
    say("a signal to another rank: stopping");
    stop_.set();
  }
  case_of(report.sample).suspended(in_case(report));
  if (is_sweep()) say(fmt::format("case {}, {}", report.sample % cases_.size(), describe(in_case(report))));
}

void Run::compute() {
  schedule_samples(world_, layout_, to_do_, *this, *this, queue_limits(layout_.n_groups),
                   parameters_.ensemble.meshes);
}

RunOutcome Run::finish() {
  // True if the master was asked to stop, by a signal, the time limit or another rank.
  const bool is_stopping = parallel::share(world_, stop_.is_set());
  if (!is_sweep()) return cases_.front().finish(world_, is_stopping, options_.next, seconds_now() - start_);
  RunOutcome all;
  std::vector<CaseRows> rows;  // on the root
  for (std::size_t i = 0; i < cases_.size(); ++i) {
    RunOutcome outcome = cases_[i].finish(world_, is_stopping, {}, seconds_now() - start_);
    all.done += outcome.done;
    all.failed += outcome.failed;
    all.left += outcome.left;
    all.lost = all.lost || outcome.lost;
    if (!outcome.file_error.empty()) {
      all.file_error = outcome.file_error;
      say(fmt::format("case {}: {}", i, cannot_write(results_file(cases_[i].folder()), outcome.file_error)));
    }
    rows.push_back({&given_[i], cases_[i].folder().filename().string(), std::move(outcome.rows)});
  }
  all.stopped = is_stopping && all.left > 0 && !all.lost;
  if (all.lost) return all;
  try {
    parallel::agree_on_root(world_, [&] { write_table(std::move(rows), all); });
  } catch (const parallel::AgreedError& error) {
    all.file_error = error.what();
    say(cannot_write(sweep_table(options_.folder), all.file_error));
  }
  const bool is_whole = all.left == 0 && all.file_error.empty();
  if (!is_whole && !options_.next.resume.empty()) say("to continue: " + options_.next.resume);
  if (is_whole && all.failed > 0 && !options_.next.retry_failed.empty())
    say("to compute failed samples again: " + options_.next.retry_failed);
  return all;
}

void Run::write_table(std::vector<CaseRows> rows, const RunOutcome& all) const {
  for (std::size_t i = 0; i < cases_.size(); ++i) {
    if (!rows[i].rows.empty()) continue;
    const auto n = static_cast<std::size_t>(cases_[i].parameters().ensemble.samples);
    rows[i].rows = io::read_summaries(cases_[i].folder(), cases_[i].parameters(), 0, n);
  }
  if (log_) log_->end_progress();
  say(fmt::format("{} cases: {} done, {} failed, {} pending after {}", cases_.size(), all.done, all.failed,
                  all.left, duration_text(seconds_now() - start_)));
  if (log_) *options_.log << sweep_text(rows);
  io::write_text_file(sweep_table(options_.folder), sweep_csv(rows));
  say(sweep_table(options_.folder).string());
}

}  // namespace

RunOutcome run(const parallel::Communicator& world, const input::Parameters& parameters,
               const std::vector<input::Case>& cases, const RunOptions& options, const Mechanics& mechanics) {
  Run run(world, parameters, cases, options, mechanics);
  run.plan();
  run.begin();
  run.compute();
  return run.finish();
}

}  // namespace crackle::ensemble
