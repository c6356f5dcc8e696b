// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/sample_result.h"

#include "common/index.h"

#include <algorithm>
#include <array>

namespace crackle::dynamics {

std::string to_string(Outcome outcome) {
  constexpr std::array names{"unbroken", "arrested", "separated", "in one piece", "undecided"};
  return names.at(index(outcome));
}

void truncate_results(SampleResult& result, double end_time) {
  const bool has_loaded_on = std::ranges::any_of(
      result.breaks, [&](const fracture::Break& one) { return one.load_time > result.phase_start; });
  if (has_loaded_on) return;
  const auto is_late_row = [&](const EnergyRow& row) { return row.time > end_time; };
  std::erase_if(result.energy, is_late_row);
  std::erase_if(result.fragment_history, [&](const FragmentCount& row) { return row.time > end_time; });
  std::erase_if(result.history, [&](const HistoryRow& row) {
    return row.phase == result.counts.dynamic_phases && is_late_row(row.energy);
  });
  const auto is_late = [&](const auto& release) {
    return release.load_time == result.phase_start && release.phase_time > end_time;
  };
  std::erase_if(result.breaks, is_late);
  std::erase_if(result.bridge_releases, is_late);
  std::erase_if(result.stiffness_reductions, is_late);
}

}  // namespace crackle::dynamics
