// SPDX-License-Identifier: GPL-3.0-or-later
#include "state_range.h"

#include "common/index.h"
#include "common/real.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace crackle::dynamics {

namespace {

// Safety factor over the estimates below, for superposed waves and stress concentrations at notches and crack
// fronts.
constexpr double load_concentration = 8;
/// Strain of an edge in a body that is still intact.
constexpr double largest_strain = 0.05;
// Small fragments, which have the shortest edges, rotate by radians while they fly away: by so many at least,
// as far as that share of their flight lets them, and by so many at most, for the sake of resolution.
constexpr double least_turn = 16;
constexpr double turning_share = 0.25;
constexpr double largest_turn = 64;
constexpr double velocity_room = 32;
constexpr double force_room = 4;

/// This rank's extremes; reduced by the maximum over the ranks.
struct Extremes {
  double velocity = 0;
  double state_stress = 0;
  double stretch_force = 0;  // of an edge, per strain
  double longest_edge = 0;
  double shortest_edge = -infinity;  // negated, so that the maximum can be taken
  double strength = 0;
  double impedance = 0;                // of shear waves, largest
  double least_impedance = -infinity;  // negated
  double least_modulus = -infinity;    // Young's, negated

  void all_reduce(const parallel::Communicator& group) {
    const std::array<double*, 9> all{&velocity,     &state_stress,    &stretch_force,
                                     &longest_edge, &shortest_edge,   &strength,
                                     &impedance,    &least_impedance, &least_modulus};
    std::array<double, 9> values{};
    std::ranges::transform(all, values.begin(), [](const double* value) { return *value; });
    parallel::check_peers(group);
    parallel::all_reduce(group, values, MPI_MAX);
    for (std::size_t i = 0; i < all.size(); ++i) *all[i] = values[i];
  }
};

double largest_component(std::span<const double> values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

/// Velocity that the terms can give an unsupported body, and a fragment whatever supports it [m/s].
double free_flight_velocity(const MotionContext& context, const Demand& demand, double duration) {
  double of_body = 0;
  if (!demand.holds && demand.resultant > 0)
    of_body = demand.resultant / parallel::exact_sum(*context.group, context.body->operators().node_mass) *
              duration;
  return std::max(demand.acceleration * duration, of_body);
}

/// The body's material, strains and velocities.
void add_state(const MotionContext& context, const MotionState& state, Extremes& e) {
  const auto& body = *context.body;
  const auto& density = body.material().density;
  e.velocity = largest_component(state.velocity.owned());
  e.strength = largest_component(context.law->strengths());
  for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
    const double impedance = density[t] * std::sqrt(body.elasticity()[t].mu / density[t]);
    e.impedance = std::max(e.impedance, impedance);
    e.least_impedance = std::max(e.least_impedance, -impedance);
    e.least_modulus = std::max(e.least_modulus, -body.elasticity()[t].youngs_modulus());
    if (body.is_broken(t)) continue;
    const auto sigma = body.stress(t, state.displacement.local());
    e.state_stress = std::max(e.state_stress, mechanics::contract(sigma, sigma));
    // The forces of displacement and initial strain, which balance, are larger than their sum.
    if (body.initial_strain().is_none()) continue;
    const auto initial = body.intact_stress(t, body.initial_strain()[t]);
    e.state_stress = std::max(e.state_stress, 4 * mechanics::contract(initial, initial));
  }
  e.state_stress = std::sqrt(e.state_stress);
}

/// Lengths of edges, and their forces.
void add_edges(const fracture::BreakableBody& body, Extremes& e) {
  const auto& subdomain = body.subdomain();
  const auto& edges = body.edges();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto [a, b] = edges.nodes[i];
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k)
      square += std::pow(subdomain.nodes[index(a)][k] - subdomain.nodes[index(b)][k], 2);
    // Bound on the coupling from its tetrahedra, including broken ones.
    double stiffness = 0;
    for (const auto number : edges.round(static_cast<std::int32_t>(i))) {
      const auto& t = body.operators().tetrahedra[index(number)];
      const auto gradient = [&](std::int32_t node) {
        const auto& g = t.gradient[index(std::ranges::find(t.nodes, node) - t.nodes.begin())];
        return norm(g);
      };
      const auto& [lambda, mu] = body.elasticity()[number];
      // Multiply the two gradients first: a and b are swapped between ranks.
      stiffness += t.volume * (std::abs(lambda) + 2 * mu) * (gradient(a) * gradient(b));
    }
    e.stretch_force = std::max(e.stretch_force, stiffness * std::sqrt(square));
    e.longest_edge = std::max(e.longest_edge, std::sqrt(square));
    e.shortest_edge = std::max(e.shortest_edge, -std::sqrt(square));
  }
}

}  // namespace

mechanics::StateRange expected_range(const MotionContext& context, const Terms& terms, double load_time,
                                     double duration, const MotionState& state) {
  const double end = load_time + duration;
  Extremes e;
  add_state(context, state, e);
  add_edges(*context.body, e);
  e.all_reduce(*context.group);
  const Demand demand = terms.demand(load_time, end);

  const double from_loads = load_concentration * (demand.stress + e.impedance * demand.velocity);
  double stress = std::max({e.state_stress, std::min(e.strength, from_loads), 2 * e.impedance * e.velocity});
  if (!(stress > 0)) stress = e.strength;
  const double velocity = stress / -e.least_impedance;
  const double youngs_modulus = -e.least_modulus;
  const double turn =
      std::clamp(turning_share * velocity * duration / -e.shortest_edge, least_turn, largest_turn);
  return {
      std::max(largest_strain * e.longest_edge, turn * -e.shortest_edge),
      velocity_room * (velocity + demand.velocity + free_flight_velocity(context, demand, end - load_time)),
      force_room * turn / least_turn * e.stretch_force * stress / youngs_modulus, stress / youngs_modulus};
}

}  // namespace crackle::dynamics
