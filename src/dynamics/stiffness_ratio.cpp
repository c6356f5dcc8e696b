// SPDX-License-Identifier: GPL-3.0-or-later
#include "stiffness_ratio.h"

#include "common/index.h"
#include "dynamics/energy_account.h"
#include "mechanics/node_cells.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <algorithm>

namespace crackle::dynamics {

namespace {

/// Loads with less than this share of the energy of a bar equivalent to the whole body count as not straining
/// it: far below the value for the most slender body, far above the solver's error for a rigid motion.
constexpr double rigid = 1e-12;

bool are_zero(const std::vector<double>& factors) {
  return std::ranges::all_of(factors, [](double factor) { return factor == 0; });
}

/// The factors of the loads at a time; their rates if they are all zero.
std::vector<double> factors_at(std::span<const UnitLoad> loads, double time) {
  std::vector<double> factors;
  for (const UnitLoad& load : loads) factors.push_back(load.factor(time));
  if (!are_zero(factors)) return factors;
  factors.clear();
  for (const UnitLoad& load : loads) factors.push_back(load.rate(time));
  return factors;
}

std::vector<double> superposition(const std::vector<double>& factors,
                                  std::span<const parallel::NodeField> unit) {
  std::vector<double> sum(unit.front().local().size());
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const auto u = unit[k].local();
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += factors[k] * u[i];
  }
  return sum;
}

}  // namespace

double bar_stiffness(const parallel::Communicator& group, const fracture::BreakableBody& body) {
  const geometry::Box box = mechanics::box_of_all(group, body.subdomain());
  const double extent = std::ranges::max(box.upper - box.lower);
  std::vector<double> volumes;
  for (std::size_t t = 0; t < body.operators().tetrahedra.size(); ++t)
    if (body.subdomain().owned[t] != 0) volumes.push_back(body.operators().tetrahedra[t].volume);
  parallel::check_peers(group);
  const double largest = parallel::largest_of_all(
      group, std::ranges::max(body.elasticity().values(), {}, &mechanics::IsotropicElasticity::mu).mu);
  return largest * parallel::exact_sum(group, volumes) / (extent * extent);
}

StiffnessRatio::StiffnessRatio(const parallel::Communicator& group, const fracture::BreakableBody& body,
                               std::span<const UnitLoad> loads,
                               std::span<const mechanics::NodeStiffness> springs,
                               std::span<const parallel::NodeField> unit)
    : group_(&group), body_(&body), springs_(springs.begin(), springs.end()) {
  const auto count = [&](UnitLoad::Kind kind) {
    return static_cast<std::size_t>(std::ranges::count(loads, kind, &UnitLoad::kind));
  };
  forces_ = loads.first(count(UnitLoad::Kind::force));
  motions_ = loads.subspan(forces_.size(), count(UnitLoad::Kind::motion));
  const auto motions = unit.subspan(forces_.size(), motions_.size());
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    auto& row = compliance_.emplace_back();
    for (const auto& u : unit.first(forces_.size())) row.push_back(work(k, u.local()));
  }
  const mechanics::InternalForce of_displacement(body.operators(), body.residual_stiffness());
  std::vector<double> force;
  for (const auto& a : motions) {
    force.assign(a.local().size(), 0);
    of_displacement.evaluate(a.local(), force);
    mechanics::add_forces(springs_, a.local(), force);
    auto& row = stiffness_.emplace_back();
    for (const auto& b : motions)
      row.push_back(
          parallel::exact_dot(group, std::span<const double>(force).first(b.owned().size()), b.owned()));
  }
  bar_stiffness_ = bar_stiffness(group, body);
}

double StiffnessRatio::work(std::size_t force, std::span<const double> displacement) const {
  std::vector<double> of_nodes(displacement.size()), terms;
  forces_[force].apply(of_nodes);
  for (std::size_t i = 0; i < of_nodes.size(); ++i)
    if (of_nodes[i] != 0) terms.push_back(of_nodes[i] * displacement[i]);
  return parallel::exact_sum(*group_, terms);
}

double StiffnessRatio::intact(const Matrix& of_pairs, const std::vector<double>& factors) {
  double sum = 0;
  for (std::size_t a = 0; a < factors.size(); ++a)
    for (std::size_t b = 0; b < factors.size(); ++b) sum += factors[a] * factors[b] * of_pairs[a][b];
  return sum;
}

double StiffnessRatio::share_of_forces(const std::vector<double>& factors,
                                       std::span<const parallel::NodeField> unit) const {
  double squares = 0;
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const double force = factors[k] * forces_[k].total;
    squares += force * force;
  }
  const double before = intact(compliance_, factors);
  if (!(before > rigid * squares / bar_stiffness_)) return 1;
  const std::vector<double> u = superposition(factors, unit);
  double done = 0;
  for (std::size_t k = 0; k < factors.size(); ++k) done += factors[k] * work(k, u);
  const double stored = 2 * change_energy(*group_, *body_, springs_, u);
  return before * stored < done * done ? before * stored / (done * done) : 1;
}

double StiffnessRatio::share_of_motions(const std::vector<double>& factors,
                                        std::span<const parallel::NodeField> unit) const {
  double squares = 0;
  for (const double factor : factors) squares += factor * factor;
  const double before = intact(stiffness_, factors);
  if (!(before > rigid * squares * bar_stiffness_)) return 1;
  return std::min(1.0, 2 * change_energy(*group_, *body_, springs_, superposition(factors, unit)) / before);
}

double StiffnessRatio::at(double time, std::span<const parallel::NodeField> unit) const {
  const std::vector<double> forces = factors_at(forces_, time), motions = factors_at(motions_, time);
  double share = 1;
  if (!are_zero(forces)) share = share_of_forces(forces, unit.first(forces_.size()));
  if (!are_zero(motions)) share = std::min(share, share_of_motions(motions, unit.subspan(forces_.size())));
  return share;
}

}  // namespace crackle::dynamics
