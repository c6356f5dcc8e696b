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

}  // namespace

void apply_loads(const mechanics::Conditions& loads, double time, LoadState& state) {
  state.conditions.resize(loads.conditions.size());
  for (const auto& pattern : loads.forces) {
    ConditionState& condition = state.conditions[index(pattern.condition)];
    condition.amplitude = pattern.amplitude.at(time);
    condition.applied[index(pattern.component)] = condition.amplitude * pattern.acting_resultant();
  }
}

void measure_forces(const parallel::Communicator& group, const mechanics::Conditions& loads,
                    const parallel::NodeField& displacement, double time, LoadState& state) {
  Addends terms;
  for (const auto& pattern : loads.forces) {
    auto& sum = terms.emplace_back();
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i)
      sum.push_back(pattern.weight[i] * displacement.local()[index(pattern.nodes[i], pattern.component)]);
  }
  const auto sums = parallel::exact_sums(group, terms);
  apply_loads(loads, time, state);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const auto& pattern = loads.forces[k];
    const auto c = index(pattern.component);
    ConditionState& condition = state.conditions[index(pattern.condition)];
    condition.position[c] = sums[k];
    if (pattern.acting_weight() != 0) condition.displacement[c] = sums[k] / pattern.acting_weight();
    state.works.push_back({pattern.amplitude.at(time), sums[k]});
  }
}

void measure_motions(const parallel::Communicator& group, const fracture::BreakableBody& body,
                     const mechanics::Conditions& loads, const parallel::NodeField& displacement, double time,
                     LoadState& state) {
  state.conditions.resize(loads.conditions.size());
  if (loads.motions.empty()) return;
  std::vector<double> force(displacement.local().size()), external(displacement.owned().size());
  body.force().evaluate(loads.constrained_tetrahedra, displacement.local(), force);
  loads.add_forces(time, external);
  for (const auto& [component, push] : state.borne) external[component] += push;
  Addends terms;  // of each reaction, and of its conjugate where that differs
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
  const auto sums = parallel::exact_sums(group, terms);
  auto next = sums.begin();
  for (const auto& motion : loads.motions) {
    ConditionState& condition = state.conditions[index(motion.condition)];
    const double reaction = *next++, travel = motion.displacement(time);
    condition.reaction[index(motion.component)] = reaction;
    condition.displacement[index(motion.component)] = travel;
    state.works.push_back({motion.has_factor ? *next++ : reaction, travel, true});
  }
}

LoadState measure_loads(const parallel::Communicator& group, const fracture::BreakableBody& body,
                        const mechanics::Conditions& loads, const parallel::NodeField& displacement,
                        double time) {
  LoadState state;
  measure_forces(group, loads, displacement, time, state);
  measure_motions(group, body, loads, displacement, time, state);
  return state;
}

void measure_initial_strain(const parallel::Communicator& group, const fracture::BreakableBody& body,
                            const parallel::NodeField& displacement, LoadState& state) {
  const mechanics::InitialStrain& initial = body.initial_strain();
  if (initial.is_none()) return;
  Addends terms(initial.parts().size());  // of the conjugate of each part's factor
  for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
    if (body.subdomain().owned[index(t)] == 0) continue;
    const auto sigma = body.residual_stiffness().stress(t, body.strain(t, displacement.local()));
    const double volume = body.operators().tetrahedra[index(t)].volume;
    for (std::size_t k = 0; k < terms.size(); ++k)
      terms[k].push_back(-volume * mechanics::contract(sigma, initial.parts()[k].strain[index(t)]));
  }
  const auto sums = parallel::exact_sums(group, terms);
  for (std::size_t k = 0; k < sums.size(); ++k)
    state.works.push_back({sums[k], initial.parts()[k].factor.at(initial.time())});
}

void measure_absorbers(const parallel::Communicator& group, const mechanics::Conditions& loads,
                       const parallel::NodeField& velocity, LoadState& state) {
  if (loads.absorbers.empty()) return;
  const auto v = velocity.owned();
  Addends terms(3 * loads.absorbers.size());
  for (std::size_t a = 0; a < loads.absorbers.size(); ++a)
    for (std::size_t n = 0; n < loads.absorbers[a].nodes.size(); ++n) {
      const auto first = index(loads.absorbers[a].nodes[n], 0);
      const Vector force =
          mechanics::apply(loads.absorbers[a].impedance[n], {v[first], v[first + 1], v[first + 2]});
      for (std::size_t c = 0; c < 3; ++c) terms[3 * a + c].push_back(-force[c]);
    }
  const auto sums = parallel::exact_sums(group, terms);
  for (std::size_t k = 0; k < sums.size(); ++k)
    state.conditions[index(loads.absorbers[k / 3].condition)].reaction[k % 3] = sums[k];
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
