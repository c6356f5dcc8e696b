// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/energy_account.h"

#include "common/index.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::dynamics {

namespace {

using Addends = std::vector<std::vector<double>>;  // of each sum

double work_between(const Work& from, const Work& to) {
  return 0.5 * (from.force + to.force) * (to.displacement - from.displacement);
}

/// Adds the terms of the force of an absorbing face on the body [N], three sums.
void add_dashpot_force(const mechanics::Absorber& absorber, std::span<const double> velocity,
                       Addends& terms) {
  const std::size_t first_sum = terms.size();
  terms.resize(first_sum + 3);
  for (std::size_t n = 0; n < absorber.nodes.size(); ++n) {
    const auto first = index(absorber.nodes[n], 0);
    const Vector force =
        mechanics::apply(absorber.impedance[n], {velocity[first], velocity[first + 1], velocity[first + 2]});
    for (std::size_t c = 0; c < 3; ++c) terms[first_sum + c].push_back(-force[c]);
  }
}

/// Adds the terms of the conjugates of the factors of the initial strain, a sum for each of its parts.
void add_initial_force(const fracture::BreakableBody& body, std::span<const double> displacement,
                       Addends& terms) {
  const mechanics::InitialStrain& initial = body.initial_strain();
  const std::size_t first_sum = terms.size();
  terms.resize(first_sum + initial.parts().size());
  for (std::int32_t t = 0; !initial.is_none() && t < body.subdomain().n_tetrahedra(); ++t) {
    if (body.subdomain().owned[index(t)] == 0) continue;
    const auto sigma = body.residual_stiffness().stress(t, body.strain(t, displacement));
    const double volume = body.operators().tetrahedra[index(t)].volume;
    for (std::size_t k = 0; k < initial.parts().size(); ++k)
      terms[first_sum + k].push_back(-volume *
                                     mechanics::contract(sigma, initial.parts()[k].strain[index(t)]));
  }
}

/// Adds the terms of the reaction of each driven component, and of its conjugate where that differs.
void add_reactions(const fracture::BreakableBody& body, const mechanics::Conditions& loads, double time,
                   const parallel::NodeField& displacement, Addends& terms) {
  if (loads.motions.empty()) return;
  std::vector<double> force(displacement.local().size()), external(displacement.owned().size());
  body.force().evaluate(loads.constrained_tetrahedra, displacement.local(), force);
  loads.add_forces(time, external);
  for (const auto& motion : loads.motions) {
    std::vector<double> reaction;
    for (const auto node : motion.nodes) {
      const auto i = index(node, motion.component);
      reaction.push_back(force[i] - external[i]);
    }
    terms.push_back(reaction);
    if (!motion.has_factor) continue;
    for (std::size_t i = 0; i < reaction.size(); ++i) reaction[i] *= motion.factor_at(i);
    terms.push_back(std::move(reaction));
  }
}

}  // namespace

LoadState measure_loads(const parallel::Communicator& group, const fracture::BreakableBody& body,
                        const mechanics::Conditions& loads, const parallel::NodeField& displacement,
                        double time, const parallel::NodeField* velocity) {
  const auto u = displacement.local();
  Addends terms;
  for (const auto& pattern : loads.forces) {
    auto& sum = terms.emplace_back();
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i)
      sum.push_back(pattern.weight[i] * u[index(pattern.nodes[i], pattern.component)]);
  }
  add_reactions(body, loads, time, displacement, terms);
  if (velocity == nullptr)
    add_initial_force(body, u, terms);
  else
    for (const auto& absorber : loads.absorbers) add_dashpot_force(absorber, velocity->owned(), terms);

  const auto sums = parallel::exact_sums(group, terms);
  auto next = sums.begin();
  LoadState state;
  for (const auto& pattern : loads.forces) {
    state.amplitude.push_back(pattern.amplitude.at(time));
    state.position.push_back(*next++);
    state.works.push_back({state.amplitude.back(), state.position.back()});
  }
  for (const auto& motion : loads.motions) {
    state.reaction.push_back(*next++);
    state.travel.push_back(motion.displacement(time));
    state.works.push_back({motion.has_factor ? *next++ : state.reaction.back(), state.travel.back(), true});
  }
  if (velocity == nullptr)
    for (const auto& part : body.initial_strain().parts())
      state.works.push_back({*next++, part.factor.at(body.initial_strain().time())});
  else
    for (std::size_t a = 0; a < loads.absorbers.size(); ++a, next += 3)
      state.absorbed.push_back({next[0], next[1], next[2]});
  return state;
}

double strain_energy(const LoadState& state) {
  double twice = 0;
  for (const bool is_driven : {false, true})
    for (const Work& work : state.works)
      if (work.is_driven == is_driven) twice += work.force * work.displacement;
  return twice / 2;
}

double static_work(const LoadState& from, const LoadState& to) {
  double sum = 0;
  for (std::size_t k = 0; k < from.works.size(); ++k) sum += work_between(from.works[k], to.works[k]);
  return sum;
}

double strain_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const double> displacement) {
  return parallel::exact_sum(group, body.strain_energies(displacement));
}

double change_energy(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     std::span<const mechanics::NodeStiffness> springs, std::span<const double> change) {
  std::vector<double> energies = body.change_energies(change);
  for (const auto& spring : springs) {
    const Vector force = spring.force(change);
    for (std::size_t i = 0; i < 3; ++i)
      energies.push_back(0.5 * change[index(spring.node, 0) + i] * force[i]);
  }
  return parallel::exact_sum(group, energies);
}

void EnergyAccount::add_static_work(const LoadState& from, const LoadState& to) {
  for (std::size_t k = 0; k < from.works.size(); ++k) external_ += work_between(from.works[k], to.works[k]);
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
    if (body.subdomain().owned[t] == 0) continue;
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
