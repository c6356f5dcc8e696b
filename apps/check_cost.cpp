// SPDX-License-Identifier: GPL-3.0-or-later
#include "check.h"

#include "common/heartbeat.h"
#include "common/quantity_text.h"
#include "common/text_table.h"
#include "dynamics/first_break_prediction.h"
#include "dynamics/model_limits.h"
#include "input/reader.h"

#include "commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace crackle::apps {

namespace {

using Rows = std::vector<NamedValue>;

/// Measured duration of the time loop [s].
constexpr double measured_seconds = 1;
/// Bodies up to this size are solved for a body that starts at rest, too.
constexpr double soon_solved = 400e3;  // tetrahedra

double forces_per_step(const ensemble::PhaseWork& phase) {
  return static_cast<double>(phase.force_evaluations) / static_cast<double>(phase.grid.n_steps);
}

/// Recommends the number of ranks per sample.
std::string plan_text(const FirstSample& subject, const ensemble::SampleCost& cost, std::int64_t n_ranks) {
  const ensemble::Network network;
  const ensemble::PartSizes parts(subject.realization, subject.parameters.fracture.length,
                                  ensemble::most_ranks_per_sample(subject.n_tetrahedra(), n_ranks),
                                  subject.ratio());
  const auto plans =
      ensemble::make_plans(parts, subject.n_nodes(), subject.parameters, cost, n_ranks, network);
  TextTable table{{"ranks per sample", "groups", "tetrahedra/rank", "memory/root", "memory/other", "sample",
                   "efficiency", "ensemble", ""}};
  const auto memory_text = [](double bytes) {
    return bytes == 0    ? "-"
           : bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6)
                         : fmt::format("{:.3g} GB", bytes / 1e9);
  };
  for (const auto& plan : plans)
    table.push_back({fmt::to_string(plan.ranks), fmt::to_string(plan.groups), fmt::to_string(plan.tetrahedra),
                     memory_text(plan.root_memory), memory_text(plan.memory),
                     duration_text(plan.sample_seconds), fmt::format("{:.0f} %", 100 * plan.efficiency),
                     duration_text(plan.wall_seconds),
                     plan.waits_for_master ? "groups wait for meshes" : ""});
  const auto& best = ensemble::recommended(plans);
  return fmt::format(
      "\nPlans for {} and {}, on cores as this one with messages of {:.3g} us and {:.3g} GB/s per rank:\n{}"
      "recommended: ensemble.ranks_per_sample = {}\n{}{}",
      count_text(n_ranks, "rank"), subject.samples_text(), 1e6 * network.latency, network.bandwidth / 1e9,
      aligned(table, 0, true), best.ranks,
      plans.size() > 1 ? fmt::format("Of a shared sample METIS takes {}, on one core, to divide the mesh.\n",
                                     duration_text(plans.back().division_seconds))
                       : "",
      best.waits_for_master
          ? "One master is too slow to make meshes for so many groups: set ensemble.meshes = \"auto\".\n"
          : "");
}

/// The load and time of the first break in equilibrium, up to which the loading rate has no effect; empty if
/// the loads do not break the body.
std::string loading_text(const dynamics::FirstBreakPrediction& outlook) {
  if (!std::isfinite(outlook.time)) return {};
  return fmt::format(
      "in equilibrium up to the first break ({}, after {}); until then the loading rate has no effect",
      quantity_text(outlook.load, "N"), quantity_text(outlook.time, "s"));
}

/// Core-hours above which a slip in the input is likely [h].
constexpr double unaffordable_hours = 10'000;

std::string unaffordable_text(const FirstSample& subject, double hours) {
  if (hours < unaffordable_hours) return {};
  const geometry::SpacingField spacing(subject.body, subject.parameters.mesh);
  return fmt::format(
      "{:.3g} core-hours, with {:.3g} time steps of {:.3g} tetrahedra in each dynamic phase: are "
      "time.duration = {} and spacings down to {} intended?",
      hours, static_cast<double>(subject.phase.grid.n_steps), subject.n_tetrahedra(),
      quantity_text(subject.parameters.time.duration, "s"),
      quantity_text(spacing.lower_bound(subject.body.bounds()), "m"));
}

/// The cost of a sample with the most phases to be expected, if it is not that with the least.
/// @param amount formats a time [s]
template <class Amount>
std::string up_to_text(const ensemble::PhaseRange& phases, double seconds, const Amount& amount) {
  if (phases.most == phases.least) return {};
  return fmt::format("; up to {} with {}", amount(seconds), phases.most);
}

/// @param time receives the cost of a sample, and the stress at time 0
std::string cost_text(const FirstSample& subject, int phases, std::int64_t n_ranks, SampleTime& time) {
  const auto& parameters = subject.parameters;
  const auto measured =
      ensemble::refined(ensemble::measure_cost(subject.of_realization(), parameters.output.frames,
                                               subject.realization, measured_seconds),
                        subject.ratio());
  const auto range =
      phases > 0 ? ensemble::PhaseRange{phases, phases} : ensemble::expected_phases(parameters);
  const double window = dynamics::arrest_window(parameters.time, parameters.specimen.size, measured.waves);
  const auto work = ensemble::sample_work(parameters.time, window, range.least);
  ensemble::SampleCost& cost = time.cost;
  cost = ensemble::sample_cost(measured, subject.phase, work, subject.mesh_seconds);
  time.share_at_start = measured.share_at_start;
  const double most =
      ensemble::sample_cost(measured, subject.phase,
                            ensemble::sample_work(parameters.time, window, range.most), subject.mesh_seconds)
          .total();
  const double rate = forces_per_step(subject.phase) * subject.n_tetrahedra() / measured.step;
  const bool breaks = measured.outlook.breaks;
  const int n_phases = breaks ? work.phases : work.phases_unbroken;
  Rows rows{
      {"dynamic phase",
       fmt::format("{:.3g} s for the full duration: {:.3g} ms per step, {:.3g} million tetrahedron updates "
                   "per second",
                   cost.phase, 1e3 * measured.step, rate / 1e6)}};
  if (parameters.time.start != input::Start::rest) {
    std::string solves =
        fmt::format("{:.3g} s: {:.3g} s for the first equilibrium", cost.quasi_static, measured.first_solve);
    if (breaks)
      solves +=
          fmt::format(", {:.3g} s for each of {} after breaks and arrests", measured.next_solve, work.solves);
    rows.emplace_back("quasi-static part", solves);
    if (measured.initial)
      rows.emplace_back("stress at time 0",
                        fmt::format("tension up to {:.4g} MPa, compression up to {:.4g} MPa; energy {}{}",
                                    measured.initial->tension / 1e6, measured.initial->compression / 1e6,
                                    quantity_text(measured.initial->energy, "J"),
                                    measured.share_at_start > 0 ? fmt::format("; {:.3g} % of the strength",
                                                                              100 * measured.share_at_start)
                                                                : ""));
    if (parameters.time.start == input::Start::quasi_static)
      if (std::string loading = loading_text(measured.outlook); !loading.empty())
        rows.emplace_back("loading", std::move(loading));
    if (measured.outlook.has_contact)
      rows.emplace_back("contact", "cracks close in equilibrium, so that loads grow in increments");
  }
  rows.emplace_back(
      "sample",
      fmt::format("{:.3g} s with {}{}{}", cost.total(), count_text(n_phases, "dynamic phase"),
                  n_phases > 1 ? fmt::format(", of which {} arrest{}", n_phases - 1, n_phases == 2 ? "s" : "")
                  : breaks     ? ""
                               : ": the loads never break the body",
                  breaks ? up_to_text(range, most, duration_text) : ""));
  const double hours = subject.n_samples() * cost.total() / 3600;
  const auto all_hours = [&](double seconds) {
    return fmt::format("{:.3g}", subject.n_samples() * seconds / 3600);
  };
  std::string core_hours = fmt::format("{} for {}, with {} each", all_hours(cost.total()),
                                       subject.samples_text(), count_text(n_phases, "dynamic phase"));
  if (breaks && range.most > range.least)
    core_hours += up_to_text(range, most, all_hours) +
                  ": growing cracks relieve this load, arrest and start again (--phases)";
  rows.emplace_back("core-hours", core_hours);
  std::string text = aligned(rows);
  for (const std::string& warning :
       {dynamics::weak_load_warning(measured.outlook), dynamics::large_strain_warning(measured.outlook),
        dynamics::fast_loading_warning(parameters.time.start, measured.outlook.time,
                                       measured.outlook.transit),
        unaffordable_text(subject, hours)})
    if (!warning.empty()) text += fmt::format("\nWarning: {}\n", warning);
  if (n_ranks > 0) text += plan_text(subject, cost, n_ranks);
  return text;
}

/// Ratio of the times of equilibria of two meshes.
double solve_ratio(double n_tetrahedra, double n_measured) {
  return std::pow(n_tetrahedra / n_measured, 4.0 / 3);
}

}  // namespace

std::optional<SampleTime> print_cost(const FirstSample& subject, int phases, std::int64_t n_ranks) {
  const auto& parameters = subject.parameters;
  const bool solves = parameters.time.start != input::Start::rest;
  fmt::print("\nTime of one core of this machine, from {}{:.2g} s of the time loop:\n",
             solves ? "two static solves and " : "", measured_seconds);
  std::fflush(stdout);
  Heartbeat heartbeat(notify);
  heartbeat.begin("measuring the cost");
  SampleTime time{{}, subject.n_tetrahedra(), subject.phase.force_evaluations, 0};
  try {
    fmt::print("{}", cost_text(subject, phases, n_ranks, time));
    return time;
  } catch (const ensemble::NotMeasured& error) {
    fmt::print("not measured: {}\n", error.what());
  } catch (const std::runtime_error& error) {
    // No sample uses the input's own values of random quantities, or a coarser mesh.
    if (parameters.random.empty() && !subject.stand_in) throw;
    fmt::print("not measured, with {}: {}\n",
               subject.stand_in ? "the coarser mesh" : "the input's own values", error.what());
  }
  return {};
}

double scaled_seconds(const SampleTime& measured, const FirstSample& subject) {
  const double updates = subject.n_tetrahedra() * static_cast<double>(subject.phase.force_evaluations);
  const double measured_updates = measured.n_tetrahedra * static_cast<double>(measured.force_evaluations);
  return measured.cost.dynamic * updates / measured_updates +
         measured.cost.quasi_static * solve_ratio(subject.n_tetrahedra(), measured.n_tetrahedra) +
         subject.mesh_seconds;
}

void print_rest_outlook(const FirstSample& subject) {
  const auto& parameters = subject.parameters;
  if (parameters.time.start != input::Start::rest) return;
  Heartbeat heartbeat(notify);
  heartbeat.begin("judging the loads by their waves");
  const auto outlook = dynamics::rest_outlook(subject.of_realization(), subject.realization,
                                              subject.n_tetrahedra() <= soon_solved);
  if (const auto waves = dynamics::wave_text(parameters.bulk_viscosity(), outlook.waves); !waves.empty())
    fmt::print("\nWith start = \"rest\", {}.\n", waves);
  if (const auto warning = dynamics::weak_load_warning(parameters.time, outlook); !warning.empty())
    fmt::print("\nWarning: {}\n", warning);
}

}  // namespace crackle::apps
