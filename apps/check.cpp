// SPDX-License-Identifier: GPL-3.0-or-later
// crackle check: validates an input file and estimates the cost of running it.
#include "common/failure.h"
#include "common/heartbeat.h"
#include "common/quantity_text.h"
#include "common/stopwatch.h"
#include "common/text_table.h"
#include "dynamics/model_limits.h"
#include "ensemble/memory.h"
#include "ensemble/trial.h"
#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "input/reader.h"
#include "parallel/agreement.h"
#include "uncertainty/random_inputs.h"

#include "check.h"
#include "commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::apps {

namespace {

struct CheckOptions {
  std::string file;
  bool keys = false;
  std::int64_t ranks = 0;    ///< number of ranks to plan for; 0: no plan
  int phases = 0;            ///< expected number of dynamic phases; 0: as such inputs have
  std::int64_t samples = 0;  ///< number of samples to try; 0: sample 0 only
  bool measure = true;
  double crack_speed = 0;  ///< [m/s]; 0: none
};

/// Stresses of samples at time 0 were seen to differ by up to 1.5 between meshes of one body.
constexpr double near_strength = 0.6;
constexpr int most_samples = 20;
constexpr double most_seconds = 10;

/// Starts samples as a run would.
class Trials {
public:
  /// @param base the shared mother points
  Trials(const FirstSample& subject, const geometry::MotherPoints& base, ensemble::TrialDepth depth)
      : subject_(subject), trial_(subject.parameters, subject.body, base, depth) {}

  /// Starts a sample, and keeps the reason if it would fail.
  /// @param work said while it takes long
  void start(std::int64_t sample, const std::string& work) {
    heartbeat_.begin(work);
    const bool is_made = sample == 0 && subject_.parameters.random.empty();
    const std::string failure =
        trial_.failure(static_cast<std::uint64_t>(sample), is_made ? &subject_.realization : nullptr);
    if (!failure.empty()) failures_.push_back(fmt::format("sample {} would fail: {}", sample, failure));
  }
  const std::vector<std::string>& failures() const { return failures_; }

private:
  const FirstSample& subject_;
  ensemble::Trial trial_;
  Heartbeat heartbeat_{notify};
  std::vector<std::string> failures_;
};

/// Tries sample 0 or as many samples as asked for, and says then how many would fail.
/// @return reasons of failures, each with its sample number
std::vector<std::string> try_samples(const FirstSample& subject, const geometry::MotherPoints& base,
                                     const CheckOptions& options) {
  Trials trials(subject, base, options.measure ? ensemble::TrialDepth::start : ensemble::TrialDepth::setup);
  const auto n = std::clamp<std::int64_t>(options.samples, 1, subject.n_samples());
  for (std::int64_t i = 0; i < n; ++i)
    trials.start(i, n == 1 ? "starting sample 0"
                           : fmt::format("starting sample {} ({} of {}); {} would fail so far", i, i + 1, n,
                                         trials.failures().size()));
  if (options.samples > 0)
    fmt::print("\nOf {}, {} would fail.\n", count_text(n, "sample"), trials.failures().size());
  return trials.failures();
}

/// Starts more samples, as many as ten seconds allow, where the stress of sample 0 at time 0 is so near the
/// strength that others may exceed it; says how many would fail.
/// @param share of stress in strength in sample 0, the largest
/// @return the first reason of a failure, if any
std::vector<std::string> try_scatter_at_start(const FirstSample& subject, const geometry::MotherPoints& base,
                                              double share) {
  const int n_others = std::min(subject.n_samples() - 1, most_samples);
  if (!(share > near_strength) || n_others == 0) return {};
  Trials trials(subject, base, ensemble::TrialDepth::start);
  int n_tried = 0;
  for (const Stopwatch watch; n_tried < n_others && (n_tried == 0 || watch.seconds() < most_seconds);) {
    ++n_tried;
    trials.start(n_tried, fmt::format("starting sample {}, since stresses at time 0 scatter", n_tried));
  }
  auto failures = trials.failures();
  fmt::print("\nAt time 0 the stress in sample 0 is {:.3g} % of the strength; of {} more, {} would fail.{}\n",
             100 * share, count_text(n_tried, "sample"), failures.size(),
             n_tried + 1 < subject.n_samples() ? " --samples tries more." : "");
  if (!failures.empty()) failures.resize(1);
  return failures;
}

/// @throws std::runtime_error with all failures, if any
void refuse(const std::vector<std::string>& failures) {
  if (failures.empty()) return;
  fail("{}", fmt::join(failures, "\n"));
}

/// Why one core cannot measure a sample here; empty if it can.
std::optional<std::string> measuring_shortage(const FirstSample& subject,
                                              const ensemble::AvailableMemory& available) {
  input::Parameters measured = subject.of_realization();
  measured.output.frames = 0;  // no frames are stored
  const double needed =
      ensemble::memory_demand(measured, subject.n_nodes() / subject.ratio(),
                              subject.n_tetrahedra() / subject.ratio(), ensemble::one_group(1))
          .root;
  return ensemble::shortage(needed, "measuring the cost", available);
}

/// Outcome of trying and measuring an input, or the first case of a sweep.
struct Estimate {
  std::vector<std::string> failures;  ///< reasons why samples would fail
  std::optional<SampleTime> time;     ///< if measured
};

/// Prints each part as soon as it is known.
Estimate print_estimate(const input::Parameters& parameters, const CheckOptions& options) {
  const auto body = geometry::make_body(parameters);
  const auto available = ensemble::available_memory();
  const auto warnings = [&] {
    Heartbeat heartbeat(notify);
    heartbeat.begin("examining the input");
    return dynamics::model_warnings(parameters, *body);
  }();
  for (const std::string& warning : warnings) fmt::print("Warning: {}\n\n", warning);
  std::fflush(stdout);
  geometry::MotherPoints base;
  const FirstSample subject = make_subject(parameters, *body, base, options.samples > 0);
  print_subject(subject, available, options.crack_speed);
  if (const auto shortage = measuring_shortage(subject, available)) {
    fmt::print("\nNo sample was started and the cost was not measured: {}\n", *shortage);
    return {};
  }
  Estimate estimate;
  if (!subject.stand_in) estimate.failures = try_samples(subject, base, options);
  if (options.measure) {
    print_rest_outlook(subject);
    if (estimate.failures.empty()) estimate.time = print_cost(subject, options.phases, options.ranks);
    if (estimate.time && options.samples == 0 && !subject.stand_in)
      estimate.failures = try_scatter_at_start(subject, base, estimate.time->share_at_start);
  } else {
    fmt::print("\nNot measured: the load of the first break, time and core-hours.\n");
  }
  return estimate;
}

/// Prints quantiles of each random input, and the number of draws that make an invalid input.
void print_random_inputs(const input::Parameters& parameters) {
  const auto& random = parameters.random;
  if (random.empty()) return;
  const auto& ensemble = parameters.ensemble;
  std::vector<NamedValue> rows;
  for (const input::RandomInput& one : random)
    rows.emplace_back(one.key, fmt::format("{}: 90 % from {} to {}, median {}", input::describe(one),
                                           format_value(one, uncertainty::quantile(one, 0.05)),
                                           format_value(one, uncertainty::quantile(one, 0.95)),
                                           format_value(one, uncertainty::quantile(one, 0.5))));
  fmt::print("Random inputs, {} draws ({}) on {} mesh{} each:\n{}", ensemble.n_inputs(),
             input::plan_names[static_cast<std::size_t>(ensemble.plan)], ensemble.replicates,
             ensemble.replicates == 1 ? "" : "es", aligned(rows));
  constexpr std::uint64_t most_tried = 1000;
  const std::uint64_t n_tried = std::min(ensemble.n_inputs(), most_tried);
  std::uint64_t n_bad = 0;
  std::string first;
  Heartbeat heartbeat(notify);
  heartbeat.begin("drawing the random inputs");
  for (std::uint64_t i = 0; i < n_tried; ++i) {
    try {
      uncertainty::sample_parameters(parameters, i * static_cast<std::uint64_t>(ensemble.replicates));
    } catch (const std::runtime_error& error) {
      if (n_bad++ == 0) first = error.what();
    }
  }
  if (n_bad > 0) fmt::print("\nWarning: {} of {} draws will fail; the first: {}\n", n_bad, n_tried, first);
  fmt::print("\n");
}

std::vector<std::string> warnings_of(const input::Case& one) {
  return dynamics::model_warnings(one.parameters, *geometry::make_body(one.parameters));
}

/// Core-hours of a case whose samples take so long [s].
double core_hours(const input::Case& one, double seconds) {
  return one.parameters.ensemble.samples * seconds / 3600;
}

NamedValue cost_line(std::size_t number, const FirstSample& subject, double seconds, double hours) {
  return {fmt::format("case {}", number),
          fmt::format("{:.0f} tetrahedra, {} steps, {:.0f} MB; sample {}, {:.3g} core-hours",
                      subject.n_tetrahedra(), subject.phase.grid.n_steps, subject.memory() / 1e6,
                      duration_text(seconds), hours)};
}

/// Prints one line for each case of a sweep.
void print_cases(const std::vector<input::Case>& cases) {
  if (cases.empty()) return;
  fmt::print("{} cases:\n", cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) fmt::print("{:>4}  {}\n", i, to_string(cases[i].settings));
  for (const std::string& warning : input::sweep_warnings(cases)) fmt::print("\nWarning: {}\n", warning);
  fmt::print("\n");
}

/// Prints the cases after the first, whose warnings are known already: new warnings, the cost if that of the
/// first is known, and the outcome of the samples to be tried.
/// @return reasons why samples would fail, each with its case
std::vector<std::string> print_other_cases(const std::vector<input::Case>& cases,
                                           const std::optional<SampleTime>& first,
                                           const CheckOptions& options) {
  std::vector<std::string> failures;
  std::vector<std::string> known = warnings_of(cases.front());
  std::vector<NamedValue> costs;
  double all_hours = first ? core_hours(cases.front(), first->cost.total()) : 0;
  for (std::size_t i = 1; i < cases.size(); ++i) {
    const input::Parameters& parameters = cases[i].parameters;
    for (const std::string& warning : warnings_of(cases[i])) {
      if (std::ranges::find(known, warning) != known.end()) continue;
      known.push_back(warning);
      fmt::print("\nWarning: case {}: {}\n", i, warning);
    }
    if (!first && options.samples == 0) continue;
    try {
      const auto body = geometry::make_body(parameters);
      geometry::MotherPoints base;
      const FirstSample subject = make_subject(parameters, *body, base, options.samples > 0);
      if (options.samples > 0) {
        fmt::print("\nCase {}: {}", i, to_string(cases[i].settings));
        for (const std::string& failure : try_samples(subject, base, options))
          failures.push_back(fmt::format("case {}: {}", i, failure));
      }
      if (!first) continue;
      const double seconds = scaled_seconds(*first, subject);
      const double hours = core_hours(cases[i], seconds);
      costs.push_back(cost_line(i, subject, seconds, hours));
      all_hours += hours;
    } catch (const std::runtime_error& error) {
      failures.push_back(fmt::format("case {}: {}", i, error.what()));
    }
  }
  if (!costs.empty()) {
    costs.emplace_back("all cases", fmt::format("{:.3g} core-hours", all_hours));
    fmt::print("\nThe other cases, from their meshes and the time of the first:\n{}", aligned(costs));
  }
  return failures;
}

/// @throws CLI::ValidationError
double read_speed(const std::string& text) {
  const double speed = [&] {
    try {
      return input::read_value(text, "m/s");
    } catch (const std::runtime_error& error) {
      throw CLI::ValidationError("--crack-speed", error.what());
    }
  }();
  if (!(speed > 0))
    throw CLI::ValidationError("--crack-speed",
                               fmt::format("{} is not above 0; give a speed such as \"450 m/s\"", text));
  return speed;
}

int check(const parallel::Communicator& world, const CheckOptions& options,
          const std::function<void()>& start_mpi) {
  const std::string& file = options.file;
  const input::Parameters parameters = read_given_input(world, file);
  std::vector<input::Case> cases;
  if (!parameters.sweeps.empty()) cases = read_cases(world, parameters, file);
  parallel::agree_on_root(world, [&] {
    if (parameters.mesh.points)
      geometry::read_points(*parameters.mesh.points, *geometry::make_body(parameters));
    const std::string notice = input::bits_notice(parameters.time.engine);
    fmt::print("{}\n\n{}{}{}\n", file, input::echo(parameters), notice, notice.empty() ? "" : "\n");
    print_random_inputs(parameters);
    print_cases(cases);
    fmt::print("The mesh of sample 0{} and the cost of the ensemble{}:\n",
               parameters.random.empty() ? "" : ", with the input's own values,",
               cases.empty() ? "" : " of the first case");
    std::fflush(stdout);
    if (options.measure || !parameters.tools.empty())
      start_mpi();  // contact with tools is looked for in fields
    try {
      auto [failures, time] = print_estimate(cases.empty() ? parameters : cases.front().parameters, options);
      if (!cases.empty()) {
        const auto others = print_other_cases(cases, time, options);
        failures.insert(failures.end(), others.begin(), others.end());
      }
      refuse(failures);
    } catch (const std::runtime_error& error) {
      fail("{}: {}", file, error.what());
    }
    if (parameters.ensemble.samples == 1)
      fmt::print(
          "\nOne sample shows no scatter: statistics, and comparisons with experiments, need some 20.\n");
    fmt::print("\n{} is valid\n", file);
  });
  return success;
}

}  // namespace

void add_check_command(CLI::App& app, const std::function<void()>& start_mpi, Action& run) {
  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand(
      "check", "Validate an input file; print the resolved values and the estimated cost of the run");
  command->add_option("input", options->file, "input file (TOML)");
  command->add_flag("--keys", options->keys, "print the list of all input keys (Markdown) instead");
  CLI::Option* const ranks =
      command
          ->add_option("--ranks", options->ranks,
                       "plan for this many ranks: how many should share a sample, and how long it takes")
          ->check(CLI::Range(1, 10'000'000));
  command
      ->add_option("--phases", options->phases,
                   "assumed number of dynamic phases per sample, including the last one, in which cracks do "
                   "not arrest [2, or a range where growing cracks relieve the load]")
      ->check(CLI::Range(1, 1000));
  command
      ->add_option("--samples", options->samples,
                   "start this many samples (of each case of a sweep) as crackle run would, and report how "
                   "many would fail")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_flag("!--no-measure", options->measure,
                 "neither measure the cost of a sample on this machine nor solve for equilibria")
      ->excludes(ranks);
  command->add_option_function<std::string>(
      "--crack-speed", [options](const std::string& text) { options->crack_speed = read_speed(text); },
      "print the release_speed with which cracks run at this speed, such as \"450 m/s\"");
  command->callback([options, start_mpi, &run] {
    if (options->keys != options->file.empty()) {
      throw CLI::ValidationError("check takes either an input file or --keys");
    }
    run.work = [options, start_mpi](const parallel::Communicator& world) {
      if (!options->keys) return check(world, *options, start_mpi);
      if (world.is_root()) fmt::print("{}", input::key_list());
      return static_cast<int>(success);
    };
  });
}

}  // namespace crackle::apps
