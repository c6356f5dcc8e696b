// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/machine_load.h"

#include "common/index.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crackle::dynamics {

namespace {

/// The peak is where the load first comes this close to its maximum: a prescribed force continues while the
/// body breaks.
constexpr double peak_share = 0.999;

Load load_of_condition(const mechanics::GoverningCondition& governing, const mechanics::Conditions& loads,
                       const LoadState& state) {
  if (const std::size_t n = loads.conditions.size(); index(governing.condition) >= n) {
    if (state.tools.empty()) return {};  // of applied loads only
    const ToolState& tool = state.tools[index(governing.condition) - n];
    if (governing.direction == Vector{}) return {norm(tool.reaction), norm(tool.displacement)};
    return {dot(tool.reaction, governing.direction), dot(tool.displacement, governing.direction)};
  }
  const ConditionState& condition = state.conditions[index(governing.condition)];
  if (governing.area > 0) {  // a pressure
    const double sign = governing.direction[0] < 0 ? -1 : 1;
    const double area = governing.area * loads.conditions[index(governing.condition)].acting_share;
    Load load;
    if (area == 0) return load;
    load.force = sign * condition.amplitude * area;
    for (const double position : condition.position) load.displacement += sign * position / area;
    return load;
  }
  const Vector force = condition.force(), &displacement = condition.displacement;
  // A pressure from all sides has no direction.
  if (governing.direction == Vector{}) return {norm(force), norm(displacement)};
  return {dot(force, governing.direction), dot(displacement, governing.direction)};
}

bool is_after_separation(const HistoryRow& row, const SampleResult& result) {
  return row.phase > 0 && row.phase == result.counts.dynamic_phases && row.energy.time > result.separated_at;
}

/// The static load at the displacement of `row`, had nothing broken since `start`.
double static_limit(const HistoryRow& start, const HistoryRow& row) {
  if (!(start.load_displacement > 0)) return start.load;
  return start.load * std::max(1.0, row.load_displacement / start.load_displacement);
}

}  // namespace

Load machine_load(const mechanics::Conditions& loads, const LoadState& state) {
  Load sum;
  for (const auto& governing : loads.governing) {
    const Load load = load_of_condition(governing, loads, state);
    sum.force += load.force;
    sum.displacement += load.displacement;
  }
  if (!loads.governing.empty()) sum.displacement /= static_cast<double>(loads.governing.size());
  return sum;
}

double largest_load(const mechanics::Conditions& loads, const LoadState& state) {
  double largest = 0;
  for (std::size_t c = 0; c < state.conditions.size(); ++c) {
    const bool is_fixed = std::ranges::any_of(loads.motions, [&](const mechanics::PrescribedMotion& motion) {
      return motion.is_fixed && index(motion.condition) == c;
    });
    for (const double component : state.conditions[c].force())
      if (!is_fixed) largest = std::max(largest, std::abs(component));
  }
  return largest;
}

LoadResults load_results(const SampleResult& result) {
  const bool has_inertia = result.load_is_reaction && !std::isnan(result.onset_force);
  LoadResults results;
  std::vector<const HistoryRow*> rows;  // rows that count for the peak
  const HistoryRow* start = nullptr;    // start of their dynamic phase
  for (const HistoryRow& row : result.history) {
    if (is_after_separation(row, result)) break;
    results.work_of_fracture = row.energy.external;
    if (start == nullptr || row.phase != start->phase) start = &row;
    if (row.phase == 0 || !has_inertia || row.load <= static_limit(*start, row)) rows.push_back(&row);
  }
  if (rows.empty()) return results;
  const auto load = [](const HistoryRow* row) { return row->load; };
  const auto peak = std::ranges::max_element(rows, {}, load);
  results.peak_load = load(*peak);
  const auto is_peak = [&](const HistoryRow* row) { return row->load >= peak_share * results.peak_load; };
  const auto first = std::ranges::find_if(rows, is_peak);
  results.displacement_at_peak = (**(first != rows.end() ? first : peak)).load_displacement;
  results.end_at_peak =
      results.peak_load > 0 && is_peak(rows.back()) && rows.back() == &result.history.back();
  return results;
}

double load_displacement_at(std::span<const HistoryRow> history, double load_time) {
  const auto after = std::ranges::lower_bound(history, load_time, {}, &HistoryRow::load_time);
  if (after == history.end()) return history.empty() ? not_a_number : history.back().load_displacement;
  if (after == history.begin()) return after->load_displacement;
  const auto before = std::prev(after);
  const double share = (load_time - before->load_time) / (after->load_time - before->load_time);
  return std::lerp(before->load_displacement, after->load_displacement, share);
}

std::vector<std::pair<double, double>> dynamic_intervals(const SampleResult& result) {
  std::vector<std::pair<double, double>> intervals;
  for (std::size_t i = 1; i < result.history.size(); ++i) {
    const HistoryRow &before = result.history[i - 1], &row = result.history[i];
    if (is_after_separation(row, result)) break;
    if (row.phase > 0 && row.phase == before.phase) intervals.emplace_back(before.load_time, row.load_time);
  }
  return intervals;
}

}  // namespace crackle::dynamics
