// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/sample_report.h"

#include "common/quantity_text.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>
#include <type_traits>

namespace crackle::ensemble {

namespace {

/// The word encoded by a result's number.
template <class Number>
std::string word_of(const analysis::SampleSummary& row, Number analysis::SampleSummary::*wanted) {
  std::string word;
  analysis::for_each_result([&](const analysis::ResultInfo& info, auto member) {
    if constexpr (std::is_same_v<decltype(member), Number analysis::SampleSummary::*>) {
      if (member == wanted) word = analysis::category_name(info.categories, row.*wanted);
    }
  });
  return word;
}

/// "381.2 N": in the usual unit, unless the value is far outside its range.
std::string shown_quantity(double value, const ShownUnit& usual, const std::string& si) {
  const ShownUnit unit = shown_unit(usual, si, std::abs(value));
  const double shown = value * unit.factor;
  return fmt::format(fmt::runtime(std::abs(shown) < 1 ? "{:.3g} {}" : "{:.1f} {}"), shown, unit.name);
}

std::string force_text(double force) {
  return shown_quantity(force, {"N", 1}, "N");
}

std::string length_text(double length) {
  return shown_quantity(length, {"mm", 1e3}, "m");
}

/// "onset 381.2 N", after the peak load if that was clearly higher; without an onset, "first break at 252.1
/// N"; of an unbroken or held sample "held 381.2 N".
std::string loads_text(const analysis::SampleSummary& summary) {
  if (is_unbroken(summary) || is_held(summary))
    return std::isnan(summary.peak_load) ? "" : fmt::format("held {}, ", force_text(summary.peak_load));
  if (!std::isnan(summary.onset_force) &&
      analysis::headline_load({&summary, 1}) == std::string_view("peak_load"))
    return fmt::format("peak load {}, onset {}, ", force_text(summary.peak_load),
                       force_text(summary.onset_force));
  if (!std::isnan(summary.onset_force)) return fmt::format("onset {}, ", force_text(summary.onset_force));
  if (!std::isnan(summary.first_break_load))
    return fmt::format("first break at {}, ", force_text(summary.first_break_load));
  return "";
}

/// The crack pattern or, for a solid and a body without notches, where it broke first.
std::string pattern_text(const analysis::SampleSummary& summary) {
  if (summary.pattern < 0)
    return std::isnan(summary.first_break_x)
               ? "no crack"
               : fmt::format("from x = {}, y = {}, z = {}", length_text(summary.first_break_x),
                             length_text(summary.first_break_y), length_text(summary.first_break_z));
  const std::string pattern = word_of(summary, &analysis::SampleSummary::pattern);
  if (pattern == "none") return "no main crack";
  if (pattern != "other") return pattern;
  if (!summary.position.empty() || std::isnan(summary.first_break_y)) return "other pattern";
  return fmt::format("from y = {}, z = {}", length_text(summary.first_break_y),
                     length_text(summary.first_break_z));
}

}  // namespace

std::string describe(const SampleReport& report) {
  const auto& summary = report.summary;
  if (report.suspended)
    return fmt::format("sample {} suspended after {:.1f} s{}", report.sample, report.seconds,
                       report.checkpoint_error.empty()
                           ? ""
                           : ", but its checkpoint could not be written: " + report.checkpoint_error);
  if (summary.status != analysis::SampleStatus::done) {
    return fmt::format("sample {} failed after {:.1f} s: {}", report.sample, report.seconds, summary.error);
  }
  return fmt::format(
      "sample {} done: {}, {}{}, {} of rough crack, {}, energy error {:.1e}, {:.1f} s{}{}", report.sample,
      word_of(summary, &analysis::SampleSummary::outcome), loads_text(summary), pattern_text(summary),
      shown_quantity(summary.crack_area, {"mm^2", 1e6}, "m^2"), count_text(summary.breaks, "break"),
      summary.energy_error, report.seconds,
      report.mesh_attempt == 0 ? "" : fmt::format(", mesh from attempt {}", report.mesh_attempt + 1),
      summary.note.empty() ? "" : "; " + summary.note);
}

std::vector<std::string> describe(const dynamics::SampleResult& result) {
  const auto& counts = result.counts;
  const auto& timings = result.timings;
  std::vector<std::string> lines{fmt::format("outcome: {}", dynamics::to_string(result.outcome))};
  if (!result.breaks.empty())
    lines.push_back(fmt::format("first break at t = {:.6f} s, {}", result.first_break_time,
                                quantity_text(result.first_break_load, "N")));
  if (!std::isnan(result.onset_time))
    lines.push_back(
        fmt::format("t0 = {:.6f} s, load {}", result.onset_time, quantity_text(result.onset_force, "N")));
  for (auto& line : {
           fmt::format("{}, {} of them quasi-static; {}; {} with {}",
                       count_text(result.breaks.size(), "break"), counts.quasi_static_breaks,
                       count_text(counts.dynamic_phases, "dynamic phase"),
                       count_text(counts.static_solves, "static solve"),
                       count_text(counts.solver_iterations, "iteration")),
           fmt::format("{} steps of {:.3f} ns (stable up to {:.3f} ns), {} force evaluations", counts.steps,
                       result.time_step * 1e9, result.stable_step * 1e9, counts.force_evaluations),
           result.mass_scaling ? "mass scaling: " + dynamics::to_string(*result.mass_scaling) : std::string(),
           std::isnan(result.equilibrium_residual)
               ? fmt::format("energy error {:.2e} of the work", result.energy_error)
               : fmt::format("energy error {:.2e} of the work; equilibrium residual {:.1e} of the loads",
                             result.energy_error, result.equilibrium_residual),
           fmt::format("mesh {:.1f} s, setup {:.1f} s, quasi-static {:.1f} s, dynamic {:.1f} s", timings.mesh,
                       timings.setup, timings.quasi_static, timings.dynamic),
           fmt::format("{:.3e} element updates per second", timings.element_updates_per_second),
       })
    if (!line.empty()) lines.push_back(line);
  return lines;
}

}  // namespace crackle::ensemble
