// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/conditions.h"

#include "common/index.h"
#include "geometry/body.h"
#include "geometry/condition_region.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include "condition_loads.h"
#include "loaded_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace crackle::mechanics {

namespace {

std::vector<std::int32_t> tetrahedra_at(const std::vector<PrescribedMotion>& motions,
                                        const geometry::Subdomain& subdomain) {
  std::vector<std::uint8_t> is_constrained(subdomain.nodes.size(), 0);
  for (const auto& motion : motions)
    for (const auto node : motion.nodes) is_constrained[index(node)] = 1;
  std::vector<std::int32_t> tetrahedra;
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t)
    if (std::ranges::any_of(subdomain.tetrahedra[index(t)],
                            [&](std::int32_t node) { return is_constrained[index(node)] != 0; }))
      tetrahedra.push_back(t);
  return tetrahedra;
}

/// Assigns each component of a node to one motion, drops motions left without nodes, and marks loads on
/// driven components. Collective.
void assign_shared_components(const parallel::Communicator& group, std::size_t n_owned, Conditions& loads) {
  std::vector<std::uint8_t> taken(3 * n_owned);
  for (const bool is_fixed : {true, false}) {
    for (PrescribedMotion& motion : loads.motions) {
      if (motion.is_fixed != is_fixed) continue;
      std::size_t n_kept = 0;
      for (std::size_t i = 0; i < motion.nodes.size(); ++i) {
        if (std::exchange(taken[index(motion.nodes[i], motion.component)], std::uint8_t{1}) != 0) continue;
        motion.nodes[n_kept] = motion.nodes[i];
        if (!motion.factor.empty()) motion.factor[n_kept] = motion.factor[i];
        ++n_kept;
      }
      motion.nodes.resize(n_kept);
      if (!motion.factor.empty()) motion.factor.resize(n_kept);
    }
  }
  parallel::check_peers(group);
  std::erase_if(loads.motions, [&](const PrescribedMotion& motion) {
    return !parallel::any_of_all(group, !motion.nodes.empty());
  });
  for (ForcePattern& pattern : loads.forces)
    for (const auto node : pattern.nodes) pattern.is_driven.push_back(taken[index(node, pattern.component)]);
}

/// Removes dashpots from components prescribed by a condition.
void leave_out_prescribed(const std::vector<PrescribedMotion>& motions, std::vector<Absorber>& absorbers) {
  // Indices in xx, yy, zz, yz, xz, xy that involve x, y and z.
  constexpr std::array<std::array<std::size_t, 3>, 3> with{{{0, 4, 5}, {1, 3, 5}, {2, 3, 4}}};
  for (Absorber& absorber : absorbers) {
    for (const auto& motion : motions) {
      for (const auto node : motion.nodes) {
        const auto place = std::ranges::lower_bound(absorber.nodes, node);
        if (place == absorber.nodes.end() || *place != node) continue;
        for (const std::size_t k : with[index(motion.component)])
          absorber.impedance[index(place - absorber.nodes.begin())][k] = 0;
      }
    }
  }
}

}  // namespace

double PrescribedMotion::velocity(double time, const StepSpan& step) const {
  return curve.has_kink(step) ? (displacement(step.end) - displacement(step.begin)) / (step.end - step.begin)
                              : velocity(time);
}

void Conditions::end_loads(const parallel::Communicator& group, const NodesOfConditions& nodes) {
  const auto ends = [&](int condition, std::int32_t node) {
    return std::ranges::binary_search(nodes[index(condition)], node);
  };
  // Sums over what is left, so that the result does not depend on the sequence in which loads ended.
  for (ForcePattern& pattern : forces) {
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i)
      if (ends(pattern.condition, pattern.nodes[i])) pattern.weight[i] = 0;
    std::vector<double> magnitudes = pattern.weight;
    for (double& weight : magnitudes) weight = std::abs(weight);
    parallel::check_peers(group);
    pattern.left_weight = parallel::exact_sum(group, magnitudes);
    pattern.left_resultant = parallel::exact_sum(group, pattern.weight);
  }
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    ConditionNodes& condition = conditions[c];
    if (!parallel::any_of_all(group, !nodes[c].empty())) continue;
    condition.has_ended.resize(condition.nodes.size());
    std::vector<double> acting = condition.share;
    for (std::size_t i = 0; i < condition.nodes.size(); ++i) {
      if (ends(static_cast<int>(c), condition.nodes[i])) condition.has_ended[i] = 1;
      if (!condition.acts_at(i)) acting[i] = 0;
    }
    condition.acting_share = parallel::exact_sum(group, acting);
  }
}

void Conditions::add_forces(double time, std::span<double> force) const {
  for (const auto& pattern : forces) {
    const double amplitude = pattern.amplitude.at(time);
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
      force[index(pattern.nodes[i], pattern.component)] += amplitude * pattern.weight[i];
    }
  }
}

void Conditions::set_displacements(double time, std::span<double> displacement) const {
  for (const auto& motion : motions) {
    const double value = motion.displacement(time);
    for (std::size_t i = 0; i < motion.nodes.size(); ++i)
      displacement[index(motion.nodes[i], motion.component)] = motion.factor_at(i) * value;
  }
}

Conditions make_boundary_loads(const parallel::Communicator& group, const input::Model& model,
                               const geometry::Subdomain& subdomain) {
  return make_boundary_loads(group, model, subdomain, material_field(model.materials, subdomain.material));
}

Conditions make_boundary_loads(const parallel::Communicator& group, const input::Model& model,
                               const geometry::Subdomain& subdomain, const MaterialField& material) {
  std::vector<Vector> outward;  // of every face
  std::vector<geometry::ConditionRegion> regions;
  parallel::agree(group, [&] {
    const auto body = geometry::make_body(model.specimen);
    for (const geometry::Face& face : body->faces()) outward.push_back(face.outward);
    regions = geometry::condition_regions(*body, model.boundaries);
  });
  Conditions loads;
  for (std::size_t i = 0; i < regions.size(); ++i)
    add_condition({group, subdomain, material, model.boundaries[i], static_cast<int>(i), regions[i], outward},
                  loads);
  assign_shared_components(group, index(subdomain.layout.n_owned), loads);
  leave_out_prescribed(loads.motions, loads.absorbers);
  loads.constrained_tetrahedra = tetrahedra_at(loads.motions, subdomain);
  loads.governing = governing_conditions(model);
  // The machine's load is the pressure times its area.
  for (GoverningCondition& one : loads.governing)
    if (index(one.condition) < model.boundaries.size() &&
        model.boundaries[index(one.condition)].kind == input::BoundaryKind::pressure)
      one.area = loaded_region(group, regions[index(one.condition)], subdomain,
                               model.boundaries[index(one.condition)].factor)
                     .total_area;
  return loads;
}

}  // namespace crackle::mechanics
