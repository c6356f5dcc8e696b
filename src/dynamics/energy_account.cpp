// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/energy_account.h"

#include "crackle/common/index.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/exact_sum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace crackle::dynamics {

namespace {

/// Force of an absorbing face on the body [N]. Collective.
Vector dashpot_force(const parallel::Communicator& group, const mechanics::Absorber& absorber,
                     const parallel::NodeField& field) {
  const auto velocity = field.owned();
  std::array<std::vector<double>, 3> terms;
  for (std::size_t n = 0; n < absorber.nodes.size(); ++n) {
    const auto first = index(absorber.nodes[n], 0);
    const Vector force =
        mechanics::apply(absorber.impedance[n], {velocity[first], velocity[first + 1], velocity[first + 2]});
    for (std::size_t c = 0; c < 3; ++c) terms[c].push_back(-force[c]);
  }
  Vector sum{};
  for (std::size_t c = 0; c < 3; ++c) sum[c] = parallel::exact_sum(group, terms[c]);
  return sum;
}

/// Adds the factors of the initial strain and their conjugates. Collective.
void measure_initial_strain(const parallel::Communicator& group, const fracture::BreakableBody& body,
                            std::span<const double> displacement, LoadState& state) {
  const mechanics::InitialStrain& initial = body.initial_strain();
  std::vector<std::vector<double>> terms(initial.parts().size());
  for (std::int32_t t = 0; !initial.is_none() && t < body.subdomain().n_tetrahedra(); ++t) {
    if (body.subdomain().counted[index(t)] == 0) continue;
    const auto sigma = body.residual_stiffness().stress(t, body.strain(t, displacement));
    const double volume = body.operators().tetrahedra[index(t)].volume;
    for (std::size_t k = 0; k < terms.size(); ++k)
      terms[k].push_back(-volume * mechanics::contract(sigma, initial.parts()[k].strain[index(t)]));
  }
  for (std::size_t k = 0; k < terms.size(); ++k) {
    state.initial_factor.push_back(initial.parts()[k].factor.at(initial.time()));
    state.initial_force.push_back(parallel::exact_sum(group, terms[k]));
  }
}

}  // namespace

LoadState measure_loads(const parallel::Communicator& group, const fracture::BreakableBody& body,
                        const mechanics::BoundaryLoads& loads, const parallel::NodeField& displacement,
                        double time, const parallel::NodeField* velocity) {
  LoadState state;
  std::vector<double> terms;
  const auto u = displacement.local();
  for (const auto& pattern : loads.forces) {
    terms.clear();
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
      terms.push_back(pattern.weight[i] * u[index(pattern.nodes[i], pattern.component)]);
    }
    state.amplitude.push_back(pattern.amplitude.at(time));
    state.position.push_back(parallel::exact_sum(group, terms));
  }
  std::vector<double> force(u.size()), external(displacement.owned().size());
  if (!loads.motions.empty()) {
    body.force().evaluate(loads.constrained_tetrahedra, u, force);
    loads.add_forces(time, external);
  }
  for (const auto& motion : loads.motions) {
    terms.clear();
    for (const auto node : motion.nodes) {
      const auto i = index(node, motion.component);
      terms.push_back(force[i] - external[i]);
    }
    state.reaction.push_back(parallel::exact_sum(group, terms));
    for (std::size_t i = 0; i < terms.size(); ++i) terms[i] *= motion.factor_at(i);
    state.conjugate.push_back(motion.has_factor ? parallel::exact_sum(group, terms) : state.reaction.back());
    state.travel.push_back(motion.displacement(time));
  }
  if (velocity == nullptr)
    measure_initial_strain(group, body, u, state);
  else
    for (const auto& absorber : loads.absorbers)
      state.absorbed.push_back(dashpot_force(group, absorber, *velocity));
  return state;
}

double strain_energy(const LoadState& state) {
  double twice = 0;
  for (std::size_t k = 0; k < state.amplitude.size(); ++k) twice += state.amplitude[k] * state.position[k];
  for (std::size_t k = 0; k < state.initial_factor.size(); ++k)
    twice += state.initial_factor[k] * state.initial_force[k];
  for (std::size_t m = 0; m < state.conjugate.size(); ++m) twice += state.conjugate[m] * state.travel[m];
  return twice / 2;
}

double strain_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const double> displacement) {
  return parallel::exact_sum(group, body.strain_energies(displacement));
}

double change_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const double> change) {
  return parallel::exact_sum(group, body.change_energies(change));
}

void EnergyAccount::add_static_work(const LoadState& from, const LoadState& to) {
  for (std::size_t k = 0; k < from.amplitude.size(); ++k) {
    external_ += 0.5 * (from.amplitude[k] + to.amplitude[k]) * (to.position[k] - from.position[k]);
  }
  for (std::size_t m = 0; m < from.conjugate.size(); ++m) {
    external_ += 0.5 * (from.conjugate[m] + to.conjugate[m]) * (to.travel[m] - from.travel[m]);
  }
  for (std::size_t k = 0; k < from.initial_factor.size(); ++k) {
    external_ +=
        0.5 * (from.initial_force[k] + to.initial_force[k]) * (to.initial_factor[k] - from.initial_factor[k]);
  }
}

void EnergyAccount::add_relaxation(double kinetic, const parallel::NodeField& before,
                                   const parallel::NodeField& after) {
  std::vector<double> difference(before.local().size());
  for (std::size_t i = 0; i < difference.size(); ++i) difference[i] = before.local()[i] - after.local()[i];
  dissipated_ += kinetic + change_energy(*group_, *body_, difference);
}

EnergyRow EnergyAccount::row(double time, const Measured& measured) const {
  EnergyRow row{};
  row.time = time;
  row.kinetic = measured.kinetic;
  row.strain = measured.strain;
  row.external = external_ + measured.work;
  row.released = parallel::exact_sum(*group_, body_->released_energies());
  row.dissipated = dissipated_ + measured.dissipated;
  row.broken = parallel::all_reduce<std::int64_t>(*group_, std::ssize(body_->breaks()), MPI_SUM);
  return row;
}

double energy_at_strength(const parallel::Communicator& group, const fracture::BreakableBody& body,
                          std::span<const double> strength) {
  std::vector<double> energies;
  for (std::size_t t = 0; t < strength.size(); ++t) {
    if (body.subdomain().counted[t] == 0) continue;
    const auto& [lambda, mu] = body.elasticity()[static_cast<std::int32_t>(t)];
    const double modulus = lambda + 2 * mu;
    energies.push_back(body.operators().tetrahedra[t].volume * strength[t] * strength[t] / (2 * modulus));
  }
  return parallel::exact_sum(group, energies);
}

std::optional<std::string> energy_fault(std::span<const EnergyRow> rows, std::size_t n_rows,
                                        double negligible) {
  constexpr double blow_up = 10;
  if (rows.empty()) return {};
  const EnergyRow& last = rows.back();
  const double energy = last.kinetic + last.strain + last.released;
  if (!std::isfinite(energy) || !std::isfinite(last.external))
    return fmt::format("the energies are not finite {:.4g} us after the start of the phase", 1e6 * last.time);
  if (rows.size() < 2 || 10 * rows.size() < n_rows) return {};
  double supplied = rows.front().kinetic + rows.front().strain + rows.front().released;
  for (const auto& row : rows) supplied = std::max(supplied, std::abs(row.external));
  if (energy <= std::max(blow_up * supplied, negligible)) return {};
  return fmt::format(
      "{:.4g} us after the start of the phase the energy, {:.3g} J, exceeds the supplied {:.3g} J: the time "
      "integration is unstable",
      1e6 * last.time, energy, supplied);
}

double energy_error(std::span<const EnergyRow> rows) {
  double imbalance = 0;
  double work = 0;
  for (const auto& row : rows) {
    imbalance = std::max(imbalance,
                         std::abs(row.external - row.kinetic - row.strain - row.released - row.dissipated));
    work = std::max(work, std::abs(row.external));
  }
  return work > 0 ? imbalance / work : imbalance;
}

}  // namespace crackle::dynamics
