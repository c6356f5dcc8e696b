// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/load_outlook.h"

#include "crackle/common/quantity_text.h"
#include "crackle/dynamics/machine_load.h"
#include "crackle/dynamics/sample_run.h"
#include "crackle/dynamics/sample_setup.h"
#include "crackle/fracture/principal_stress.h"
#include "crackle/geometry/partition.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace crackle::dynamics {

namespace {

/// Maximum amplification of the static stress that waves are assumed to cause.
constexpr double wave_amplification = 10;

/// Largest speed of the body at the start [m/s].
double initial_speed(const input::Parameters& parameters) {
  const input::Region bounds = input::bounds_of(parameters.specimen);
  const auto velocities = parameters.initial_velocities();
  double speed = 0;
  // A velocity that is linear in the coordinates is largest at a corner.
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vector p{}, sum{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = (corner >> k & 1u) != 0 ? bounds[k].second : bounds[k].first;
    for (const auto& velocity : velocities) sum = sum + velocity.at(p);
    speed = std::max(speed, norm(sum));
  }
  return speed;
}

/// Largest stress of the plane wave that a prescribed or initial velocity sends into the body: density times
/// dilatational speed times velocity [Pa].
double impact_stress(const input::Parameters& parameters, const mechanics::MaterialField& material,
                     std::int32_t n_tetrahedra) {
  double speed = initial_speed(parameters);
  for (const auto& condition : parameters.boundaries)
    if (condition.kind == input::BoundaryKind::velocity)
      speed = std::max(
          speed, norm(condition.value) * (condition.factor ? condition.factor->largest_magnitude() : 1));
  double impedance = 0;
  for (std::int32_t t = 0; t < n_tetrahedra; ++t)
    impedance = std::max(impedance, material.density[t] * mechanics::dilatational_speed(
                                                              material.elasticity[t], material.density[t]));
  return impedance * speed;
}

std::string text_of_load(double load) {
  return quantity_text(std::abs(load), "N");
}

std::string too_late(const input::Parameters& parameters, const LoadOutlook& outlook) {
  const double reach = std::max(parameters.time.duration, outlook.transit);
  if (!std::isfinite(outlook.time) || outlook.time <= wave_amplification * reach) return {};
  return fmt::format(
      "the loads are far from breaking the body: in equilibrium they reach the first break after {}, at "
      "about {}, but the phase lasts {}; raise the loads or their rate, or set time.start = \"quasi-static\"",
      quantity_text(outlook.time, "s"), text_of_load(outlook.load),
      quantity_text(parameters.time.duration, "s"));
}

}  // namespace

StressState stress_state(const parallel::Communicator& group, const fracture::BreakableBody& body,
                         std::span<const double> displacement) {
  std::array<double, 2> largest{};
  for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
    mechanics::Symmetric sigma = body.residual_stiffness().stress(t, body.strain(t, displacement));
    largest[0] = std::max(largest[0], fracture::largest_principal(sigma));
    for (double& component : sigma) component = -component;
    largest[1] = std::max(largest[1], fracture::largest_principal(sigma));
  }
  parallel::agree(group);
  parallel::all_reduce(group, largest, MPI_MAX);
  return {largest[0], largest[1], strain_energy(group, body, displacement)};
}

LoadOutlook first_break(QuasiStaticLoading& loading, const mechanics::BoundaryLoads& loads,
                        EnergyAccount& account) {
  LoadOutlook outlook{.share = 0};
  const auto has_broken = [&] { return loading.n_events() > 0; };
  const auto look = [&](const LoadState& now) {
    if (has_broken()) return;
    if (const double share = loading.stress_share(); share > outlook.share) {
      outlook.share = share;
      outlook.load = machine_load(loads, now).force;
    }
  };
  const QuasiStaticEnd end = loading.advance(account, has_broken, look);
  outlook.breaks = has_broken() || end != QuasiStaticEnd::no_load;
  outlook.grows = !outlook.breaks && loading.grows();
  if (!outlook.breaks) return outlook;
  outlook.share = 1;
  outlook.load = loading.load();
  if (has_broken()) outlook.time = loading.time();
  return outlook;
}

LoadOutlook static_outlook(const input::Parameters& parameters, const geometry::Realization& realization) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = geometry::split(realization, geometry::partition(realization, 1)).front();
  SampleSetup setup(self, parameters, subdomain, 0);
  if (!setup.free_motions().empty()) return {};
  // Equilibria say nothing about a wave that breaks the body.
  double least_strength = infinity;
  for (std::size_t t = 0; t < subdomain.tetrahedra.size(); ++t)
    least_strength = std::min(least_strength, setup.criterion->strength(t));
  const bool is_struck =
      parameters.time.start == input::Start::rest &&
      wave_amplification * impact_stress(parameters, setup.body.material(), subdomain.n_tetrahedra()) >=
          least_strength;
  if (is_struck) return {};
  EnergyAccount account(self, setup.body);
  QuasiStaticLoading loading(self, setup.body, setup.loads, *setup.criterion,
                             arrest_window(parameters, setup.waves), setup.average.get());
  loading.load_at_start(account);
  LoadOutlook outlook = first_break(loading, setup.loads, account);
  outlook.transit = wave_transit(parameters, setup.waves);
  return outlook;
}

std::string weak_load_warning(const input::Parameters& parameters, const LoadOutlook& outlook) {
  const bool at_rest = parameters.time.start == input::Start::rest;
  if (outlook.breaks) return at_rest ? too_late(parameters, outlook) : std::string();
  if (at_rest && (outlook.share == 0 || wave_amplification * outlook.share >= 1)) return {};
  if (outlook.share == 0)
    return fmt::format("the loads do not break the body{}: no part of it is in tension",
                       outlook.grows ? ", however high they rise" : "");
  if (outlook.load == 0)
    return fmt::format("the loads do not break the body: stresses reach {:.2g} % of those at the first break",
                       100 * outlook.share);
  return fmt::format(
      "the loads do not break the body: they reach {}, {:.2g} % of the roughly {} needed for the first "
      "break; raise them, or give a rate",
      text_of_load(outlook.load), 100 * outlook.share, text_of_load(outlook.load / outlook.share));
}

}  // namespace crackle::dynamics
