// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/history.h"

#include "crackle/common/index.h"
#include "crackle/dynamics/machine_load.h"
#include "crackle/parallel/exact_sum.h"

#include <algorithm>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Mean displacement of each condition's nodes at which it still acts, or of all of them if it has ended
/// everywhere. Collective.
std::vector<Vector> mean_displacements(const parallel::Communicator& group,
                                       std::span<const mechanics::ConditionNodes> conditions,
                                       std::span<const double> displacement) {
  std::vector<std::vector<double>> terms(3 * conditions.size());
  for (std::size_t k = 0; k < conditions.size(); ++k) {
    const auto& condition = conditions[k];
    for (std::size_t n = 0; n < condition.nodes.size(); ++n) {
      if (condition.acting_share > 0 && !condition.acts_at(n)) continue;
      for (int c = 0; c < 3; ++c)
        terms[3 * k + index(c)].push_back(condition.share[n] * displacement[index(condition.nodes[n], c)]);
    }
  }
  const auto sums = parallel::exact_sums(group, terms);
  std::vector<Vector> means(conditions.size());
  for (std::size_t k = 0; k < conditions.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      means[k][c] = sums[3 * k + c] / (conditions[k].acting_share > 0 ? conditions[k].acting_share : 1);
  return means;
}

}  // namespace

void HistoryRecorder::record_equilibrium(double load_time, const LoadState& loads,
                                         const parallel::NodeField& displacement) {
  HistoryRow row;
  row.load_time = load_time;
  row.energy = account_->row(0, {.strain = strain_energy(loads)});
  add(std::move(row), loads, displacement, nullptr);
}

void HistoryRecorder::record_motion(std::int32_t phase, double load_time, const EnergyRow& energy,
                                    const parallel::NodeField& displacement,
                                    const parallel::NodeField& velocity, bool is_output) {
  HistoryRow row;
  row.is_output = is_output;
  row.load_time = load_time + energy.time;
  row.phase = phase;
  row.energy = energy;
  const LoadState state = measure_loads(*group_, *body_, *loads_, displacement, row.load_time, &velocity);
  add(std::move(row), state, displacement, &velocity);
}

std::vector<HistoryRow> HistoryRecorder::rows_of_phase(std::int32_t phase) const {
  std::vector<HistoryRow> rows;
  std::ranges::copy_if(rows_, std::back_inserter(rows),
                       [&](const HistoryRow& row) { return row.phase == phase; });
  return rows;
}

void HistoryRecorder::add(HistoryRow row, const LoadState& state, const parallel::NodeField& displacement,
                          const parallel::NodeField* velocity) {
  const Load load = machine_load(*loads_, state);
  row.load = load.force;
  row.load_displacement = load.displacement;
  row.force.resize(loads_->conditions.size());
  for (std::size_t k = 0; k < loads_->forces.size(); ++k) {
    const auto& pattern = loads_->forces[k];
    row.force[index(pattern.condition)][index(pattern.component)] =
        state.amplitude[k] * pattern.acting_resultant();
  }
  for (std::size_t m = 0; m < loads_->motions.size(); ++m) {
    const auto& motion = loads_->motions[m];
    row.force[index(motion.condition)][index(motion.component)] = state.reaction[m];
  }
  for (std::size_t a = 0; a < state.absorbed.size(); ++a)
    row.force[index(loads_->absorbers[a].condition)] = state.absorbed[a];
  row.displacement = mean_displacements(*group_, loads_->conditions, displacement.local());
  row.probes = probes_.read(displacement, velocity);
  rows_.push_back(std::move(row));
}

}  // namespace crackle::dynamics
