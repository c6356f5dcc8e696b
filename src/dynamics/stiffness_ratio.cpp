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

std::vector<double> force_factors(const mechanics::Conditions& loads, double time) {
  std::vector<double> factors;
  for (const auto& pattern : loads.forces) factors.push_back(pattern.amplitude.at(time));
  if (!are_zero(factors)) return factors;
  factors.clear();
  for (const auto& pattern : loads.forces) factors.push_back(pattern.amplitude.slope(time));
  return factors;
}

std::vector<double> motion_factors(const mechanics::Conditions& loads, double time) {
  std::vector<double> factors;
  const auto of_all = [&](const auto& value) {
    factors.clear();
    for (const auto& motion : loads.motions)
      if (!motion.never_moves()) factors.push_back(value(motion));
  };
  of_all([time](const auto& motion) { return motion.displacement(time); });
  if (are_zero(factors)) of_all([time](const auto& motion) { return motion.velocity(time); });
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

StiffnessRatio::StiffnessRatio(const parallel::Communicator& group, const fracture::BreakableBody& body,
                               const mechanics::Conditions& loads, std::span<const parallel::NodeField> unit)
    : group_(&group), body_(&body), loads_(&loads) {
  const std::size_t n_forces = loads.forces.size();
  const auto motions = unit.subspan(n_forces);
  for (std::size_t k = 0; k < n_forces; ++k) {
    auto& row = compliance_.emplace_back();
    for (const auto& u : unit.first(n_forces)) row.push_back(work(k, {u.local().begin(), u.local().end()}));
  }
  const mechanics::InternalForce of_displacement(body.operators(), body.residual_stiffness());
  std::vector<double> force;
  for (const auto& a : motions) {
    force.assign(a.local().size(), 0);
    of_displacement.evaluate(a.local(), force);
    auto& row = stiffness_.emplace_back();
    for (const auto& b : motions)
      row.push_back(
          parallel::exact_dot(group, std::span<const double>(force).first(b.owned().size()), b.owned()));
  }
  const geometry::Box box = mechanics::box_of_all(group, body.subdomain());
  const double extent = std::ranges::max(box.upper - box.lower);
  std::vector<double> volumes;
  for (std::size_t t = 0; t < body.operators().tetrahedra.size(); ++t)
    if (body.subdomain().owned[t] != 0) volumes.push_back(body.operators().tetrahedra[t].volume);
  parallel::check_peers(group);
  const double largest = parallel::largest_of_all(
      group, std::ranges::max(body.elasticity().values(), {}, &mechanics::IsotropicElasticity::mu).mu);
  bar_stiffness_ = largest * parallel::exact_sum(group, volumes) / (extent * extent);
}

double StiffnessRatio::work(std::size_t pattern, const std::vector<double>& displacement) const {
  const auto& force = loads_->forces[pattern];
  std::vector<double> terms;
  for (std::size_t n = 0; n < force.nodes.size(); ++n)
    terms.push_back(force.weight[n] * displacement[index(force.nodes[n], force.component)]);
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
    const double force = factors[k] * loads_->forces[k].total_weight;
    squares += force * force;
  }
  const double before = intact(compliance_, factors);
  if (!(before > rigid * squares / bar_stiffness_)) return 1;
  const std::vector<double> u = superposition(factors, unit);
  double done = 0;
  for (std::size_t k = 0; k < factors.size(); ++k) done += factors[k] * work(k, u);
  const double stored = 2 * change_energy(*group_, *body_, u);
  return before * stored < done * done ? before * stored / (done * done) : 1;
}

double StiffnessRatio::share_of_motions(const std::vector<double>& factors,
                                        std::span<const parallel::NodeField> unit) const {
  double squares = 0;
  for (const double factor : factors) squares += factor * factor;
  const double before = intact(stiffness_, factors);
  if (!(before > rigid * squares * bar_stiffness_)) return 1;
  return std::min(1.0, 2 * change_energy(*group_, *body_, superposition(factors, unit)) / before);
}

double StiffnessRatio::at(double time, std::span<const parallel::NodeField> unit) const {
  const std::size_t n_forces = loads_->forces.size();
  const std::vector<double> forces = force_factors(*loads_, time), motions = motion_factors(*loads_, time);
  double share = 1;
  if (!are_zero(forces)) share = share_of_forces(forces, unit.first(n_forces));
  if (!are_zero(motions)) share = std::min(share, share_of_motions(motions, unit.subspan(n_forces)));
  return share;
}

}  // namespace crackle::dynamics
