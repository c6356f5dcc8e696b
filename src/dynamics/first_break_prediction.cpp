// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/first_break_prediction.h"

#include "crackle/common/quantity_text.h"
#include "crackle/dynamics/machine_load.h"
#include "crackle/dynamics/sample_run.h"
#include "crackle/dynamics/sample_setup.h"
#include "crackle/fracture/principal_stress.h"
#include "crackle/geometry/partition.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace crackle::dynamics {

namespace {

/// Maximum amplification of a stress by reflection, superposition and notches that is assumed possible.
constexpr double wave_amplification = 10;
/// Share of the volume beyond what is strained at notches only.
constexpr double large_part = 0.01;

std::string text_of_load(double load) {
  return quantity_text(std::abs(load), "N");
}

std::string too_late(const input::Parameters& parameters, const FirstBreakPrediction& outlook) {
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
  parallel::check_peers(group);
  parallel::all_reduce(group, largest, MPI_MAX);
  return {largest[0], largest[1], strain_energy(group, body, displacement)};
}

FirstBreakPrediction first_break(QuasiStaticLoading& loading, const mechanics::Conditions& loads,
                                 EnergyAccount& account) {
  FirstBreakPrediction outlook{.share = 0};
  const auto has_broken = [&] { return loading.n_events() > 0; };
  const auto look = [&](const LoadState& now) {
    if (has_broken()) return;
    outlook.strained = loading.strained_share(small_strain);
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

RestOutlook rest_outlook(const input::Parameters& parameters, const geometry::Realization& realization,
                         bool solves) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = geometry::split(realization, geometry::partition(realization, 1)).front();
  SampleSetup setup(self, parameters, subdomain, 0);
  RestOutlook outlook{wave_outlook(setup), {}};
  const bool may_break = wave_amplification * outlook.waves.stress >= outlook.waves.strength;
  // A slow load bends a body at far higher stresses than those of its waves.
  if (!solves || may_break || !setup.free_motions().empty()) return outlook;
  try {
    EnergyAccount account(self, setup.body);
    QuasiStaticLoading loading(self, setup.body, setup.loads, *setup.criterion,
                               arrest_window(parameters, setup.waves), setup.average.get(), nullptr,
                               setup.vicinity.get());
    loading.load_at_start(account);
    outlook.equilibrium = first_break(loading, setup.loads, account);
    outlook.equilibrium->transit = wave_transit(parameters, setup.waves);
  } catch (const std::runtime_error&) {
    // A sample that starts from rest needs no equilibrium.
  }
  return outlook;
}

std::string large_strain_warning(const FirstBreakPrediction& outlook) {
  if (!outlook.breaks || !(outlook.strained > large_part)) return {};
  return fmt::format(
      "at the first break {:.3g} % of the body is strained by more than {:.2g} %, beyond the small strains "
      "that the program assumes; is Young's modulus too low, or the strength too high?",
      100 * outlook.strained, 100 * small_strain);
}

std::string weak_load_warning(const input::Parameters& parameters, const RestOutlook& outlook) {
  if (wave_amplification * outlook.waves.stress >= outlook.waves.strength) return {};
  const auto& equilibrium = outlook.equilibrium;
  if (equilibrium && equilibrium->breaks) return too_late(parameters, *equilibrium);
  if (equilibrium && wave_amplification * equilibrium->share >= 1) return {};
  return fmt::format(
      "the loads hardly break the body: their waves reach {:.2g} % of its strength; raise them",
      100 * outlook.waves.stress / outlook.waves.strength);
}

std::string weak_load_warning(const FirstBreakPrediction& outlook) {
  if (outlook.breaks) return {};
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
