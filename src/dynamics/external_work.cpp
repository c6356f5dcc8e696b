// SPDX-License-Identifier: GPL-3.0-or-later
#include "external_work.h"

#include "crackle/common/index.h"
#include "crackle/parallel/exact_sum.h"

#include <algorithm>
#include <stdexcept>

namespace crackle::dynamics {

std::vector<double> driven_kinetic(const MotionContext& context, const MotionState& state) {
  std::vector<double> terms;
  for (const auto& motion : context.loads->motions) {
    for (const auto node : motion.nodes) {
      const double v = state.velocity.owned()[index(node, motion.component)];
      terms.push_back(0.5 * context.body->operators().node_mass[index(node)] * v * v);
    }
  }
  return terms;
}

void set_prescribed(const mechanics::Conditions& loads, double time, MotionState& state) {
  loads.set_displacements(time, state.displacement.owned());
  for (const auto& motion : loads.motions) {
    const double velocity = motion.velocity(time);
    for (std::size_t i = 0; i < motion.nodes.size(); ++i)
      state.velocity.owned()[index(motion.nodes[i], motion.component)] = motion.factor_at(i) * velocity;
  }
}

ExternalWork::ExternalWork(const MotionContext& context, double time, const MotionState& state,
                           std::span<const double> driven_kinetic_before)
    : context_(context), start_(driven_kinetic_before.begin(), driven_kinetic_before.end()) {
  for (const auto& pattern : context.loads->forces) rate_work_.emplace_back(pattern.nodes.size(), 0.0);
  for (const auto& motion : context.loads->motions) reaction_work_.emplace_back(motion.nodes.size(), 0.0);
  const auto potential = load_potential(time, state);
  start_.insert(start_.end(), potential.begin(), potential.end());
}

void ExternalWork::end_loads(double time, const mechanics::NodesOfConditions& nodes,
                             const MotionState& state) {
  const auto u = state.displacement.owned();
  for (std::size_t k = 0; k < rate_work_.size(); ++k) {
    const auto& pattern = context_.loads->forces[k];
    const double amplitude = pattern.amplitude.at(time);
    for (std::size_t n = 0; n < pattern.nodes.size(); ++n)
      if (pattern.does_work_at(n) &&
          std::ranges::binary_search(nodes[index(pattern.condition)], pattern.nodes[n]))
        rate_work_[k][n] -= amplitude * pattern.weight[n] * u[index(pattern.nodes[n], pattern.component)];
  }
}

namespace {

using NodeLists = std::vector<const std::vector<std::int32_t>*>;

NodeLists nodes_of(const auto& conditions) {
  NodeLists lists;
  for (const auto& condition : conditions) lists.push_back(&condition.nodes);
  return lists;
}

void take_out(const MotionContext& context, const NodeLists& nodes,
              const std::vector<parallel::NumberedRows>& tables, std::vector<std::vector<double>>& values) {
  if (tables.size() != values.size())
    throw std::runtime_error("the checkpoint has a different number of boundary conditions");
  for (std::size_t k = 0; k < values.size(); ++k) {
    for (std::size_t n = 0; n < values[k].size(); ++n) {
      const auto node = static_cast<std::size_t>((*nodes[k])[n]);
      values[k][n] = tables[k].number_at(context.body->subdomain().layout.number[node]);
    }
  }
}

}  // namespace

std::vector<parallel::NumberedRows> gather_at_nodes(const MotionContext& context, const NodeLists& nodes,
                                                    const std::vector<std::vector<double>>& values) {
  std::vector<parallel::NumberedRows> tables;
  for (std::size_t k = 0; k < values.size(); ++k) {
    parallel::NumberedRows local;
    for (std::size_t n = 0; n < values[k].size(); ++n) {
      const auto node = static_cast<std::size_t>((*nodes[k])[n]);
      local.add(context.body->subdomain().layout.number[node], values[k][n]);
    }
    tables.push_back(parallel::gather_rows(*context.group, local));
  }
  return tables;
}

void ExternalWork::save(MotionCheckpoint& checkpoint) const {
  checkpoint.rate_work = gather_at_nodes(context_, nodes_of(context_.loads->forces), rate_work_);
  checkpoint.reaction_work = gather_at_nodes(context_, nodes_of(context_.loads->motions), reaction_work_);
}

void ExternalWork::restore(const MotionCheckpoint& checkpoint) {
  take_out(context_, nodes_of(context_.loads->forces), checkpoint.rate_work, rate_work_);
  take_out(context_, nodes_of(context_.loads->motions), checkpoint.reaction_work, reaction_work_);
}

double ExternalWork::value(double time, const MotionState& state) const {
  std::vector<double> terms = load_potential(time, state);
  for (const double term : start_) terms.push_back(-term);
  for (const auto& works : rate_work_) {
    for (const double work : works) terms.push_back(-work);
  }
  for (const auto& works : reaction_work_) terms.insert(terms.end(), works.begin(), works.end());
  const auto driven = driven_kinetic(context_, state);
  terms.insert(terms.end(), driven.begin(), driven.end());
  return parallel::exact_sum(*context_.group, terms);
}

std::vector<double> ExternalWork::load_potential(double time, const MotionState& state) const {
  std::vector<double> terms;
  const auto u = state.displacement.owned();
  for (const auto& pattern : context_.loads->forces) {
    const double amplitude = pattern.amplitude.at(time);
    for (std::size_t n = 0; n < pattern.nodes.size(); ++n)
      if (pattern.does_work_at(n))
        terms.push_back(amplitude * pattern.weight[n] * u[index(pattern.nodes[n], pattern.component)]);
  }
  return terms;
}

}  // namespace crackle::dynamics
