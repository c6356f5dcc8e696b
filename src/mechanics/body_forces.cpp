// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "mechanics/conditions.h"
#include "parallel/exact_sum.h"

#include <cmath>
#include <utility>

namespace crackle::mechanics {

namespace {

using input::BodyLoad;
using input::LoadKind;

/// The force of component `component` at each owned node, per amplitude of the load.
std::vector<double> weights_of(const BodyLoad& load, int component, const geometry::Subdomain& subdomain,
                               const std::vector<double>& amount) {
  std::vector<double> weights = amount;
  if (load.kind == LoadKind::angular_velocity)
    for (std::size_t n = 0; n < weights.size(); ++n)
      weights[n] *= load.at(subdomain.nodes[n])[index(component)];
  return weights;
}

LoadCurve amplitude_of(const BodyLoad& load, int component) {
  if (load.kind == LoadKind::angular_velocity) return {1, 0, load.history};
  return {load.value[index(component)], load.rate[index(component)], load.history};
}

double sum_of_magnitudes(const parallel::Communicator& group, std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return parallel::exact_sum(group, values);
}

/// The share of each node in the load's magnitude, which for a rotation grows with the distance from the
/// axis. Collective. @return with the total magnitude per amplitude
std::pair<ConditionNodes, double> shares_of(const parallel::Communicator& group, const BodyLoad& load,
                                            const geometry::Subdomain& subdomain,
                                            std::vector<double> amount) {
  ConditionNodes condition;
  for (std::size_t n = 0; n < amount.size(); ++n) {
    condition.nodes.push_back(static_cast<std::int32_t>(n));
    if (load.kind == LoadKind::angular_velocity) amount[n] *= norm(load.at(subdomain.nodes[n]));
  }
  const double total = parallel::exact_sum(group, amount);
  condition.share = std::move(amount);
  for (double& share : condition.share) share /= total > 0 ? total : 1;
  return {std::move(condition), total};
}

/// Marks the nodes whose component is also prescribed by a motion.
void mark_driven(const std::vector<PrescribedMotion>& motions, ForcePattern& pattern) {
  pattern.is_driven.assign(pattern.nodes.size(), 0);
  for (const PrescribedMotion& motion : motions)
    if (motion.component == pattern.component)
      for (const auto node : motion.nodes) pattern.is_driven[index(node)] = 1;
}

void add_body_force(const parallel::Communicator& group, const BodyLoad& load,
                    const geometry::Subdomain& subdomain, const std::vector<double>& amount,
                    Conditions& loads) {
  const int number = static_cast<int>(loads.conditions.size());
  auto [condition, magnitude] = shares_of(group, load, subdomain, amount);
  for (int component = 0; component < 3; ++component) {
    LoadCurve amplitude = amplitude_of(load, component);
    if (amplitude.is_zero()) continue;
    ForcePattern pattern;
    pattern.component = component;
    pattern.amplitude = std::move(amplitude);
    pattern.nodes = condition.nodes;
    pattern.weight = weights_of(load, component, subdomain, amount);
    pattern.total_weight = sum_of_magnitudes(group, pattern.weight);
    if (pattern.total_weight == 0) continue;
    pattern.resultant = parallel::exact_sum(group, pattern.weight);
    pattern.condition = number;
    pattern.is_body_force = true;
    mark_driven(loads.motions, pattern);
    loads.forces.push_back(std::move(pattern));
  }
  // The forces of a rotation point in all directions; their magnitudes add up to the machine's load.
  if (load.kind == LoadKind::angular_velocity)
    for (GoverningCondition& one : loads.governing)
      if (one.condition == number) one.area = magnitude;
  loads.conditions.push_back(std::move(condition));
}

}  // namespace

void add_body_forces(const parallel::Communicator& group, std::span<const BodyLoad> forces,
                     const geometry::Subdomain& subdomain, const PdsOperators& operators, Conditions& loads) {
  for (const BodyLoad& load : forces)
    add_body_force(group, load, subdomain,
                   load.kind == LoadKind::body_force ? operators.node_volume : operators.node_mass, loads);
}

}  // namespace crackle::mechanics
