// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/first_break_prediction.h"

#include "common/index.h"
#include "common/quantity_text.h"
#include "dynamics/machine_load.h"
#include "dynamics/sample_run.h"
#include "dynamics/tool_shape.h"
#include "fracture/equivalent_stress.h"
#include "geometry/body.h"
#include "geometry/condition_region.h"
#include "geometry/partition.h"
#include "input/plausibility.h"
#include "mechanics/elasticity.h"
#include "mechanics/loaded_region.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace crackle::dynamics {

namespace {

/// Half the spacings over which a load that overshoots rises.
constexpr double spacings_of_a_front = 2;

/// Largest values of a quantity up to two times.
struct Peak {
  double early = 0, whole = 0;
};

/// @param at value at a time, linear between the kinks of a curve or a constant there
template <class At>
Peak peak_of(const mechanics::LoadCurve& curve, double early, double whole, const At& at) {
  Peak peak;
  for (double time = 0; time <= whole; time = curve.next_kink(time)) {
    peak.whole = std::max(peak.whole, std::abs(at(time)));
    if (time <= early) peak.early = peak.whole;
  }
  peak.early = std::max(peak.early, std::abs(at(early)));
  peak.whole = std::max({peak.whole, peak.early, std::abs(at(whole))});
  return peak;
}

/// The waves of several loads, of which each sends its components at the same time.
class Waves {
public:
  explicit Waves(const SampleSetup& setup) : setup_(setup), duration_(setup.model.time.duration) {
    const auto& model = setup.model;
    early_ =
        std::min(duration_, spacings_of_a_front * model.mesh.finest_spacing() / setup.waves.dilatational);
    const auto& material = setup.body.material();
    for (std::int32_t t = 0; t < setup.subdomain.n_tetrahedra(); ++t) {
      const double density = material.density[t];
      impedance_ =
          std::max(impedance_, density * mechanics::dilatational_speed(material.elasticity[t], density));
    }
  }

  void add_forces() {
    const auto& model = setup_.model;
    const auto body = geometry::make_body(model);
    const auto regions = geometry::condition_regions(*body, model.boundaries);
    for (std::size_t c = 0; c < setup_.loads.conditions.size(); ++c) {
      std::vector<Peak> components;
      for (const auto& pattern : setup_.loads.forces) {
        if (index(pattern.condition) != c || pattern.total_weight == 0) continue;
        const Peak peak = peak_of(pattern.amplitude, early_, duration_,
                                  [&](double time) { return pattern.amplitude.at(time); });
        const double density =
            pattern.is_body_force ? whole_density(pattern) : densest_share(pattern, regions[c]);
        components.push_back({peak.early * density, peak.whole * density});
      }
      add(components, 1);
    }
  }

  void add_motions() {
    for (std::size_t c = 0; c < setup_.loads.conditions.size(); ++c) {
      std::vector<Peak> components;
      for (const auto& motion : setup_.loads.motions) {
        if (index(motion.condition) != c || motion.never_moves()) continue;
        if (motion.displacement(0) != 0) stress_ = infinity;
        double factor = motion.factor.empty() ? 1 : 0;
        for (const double one : motion.factor) factor = std::max(factor, std::abs(one));
        const Peak peak =
            peak_of(motion.curve, early_, duration_, [&](double time) { return motion.velocity(time); });
        components.push_back({peak.early * factor, peak.whole * factor});
      }
      add(components, impedance_);
    }
    const bool is_free = setup_.loads.motions.empty() && setup_.loads.absorbers.empty();
    const double speed = input::initial_speed(setup_.model, is_free);
    add({{speed, speed}}, impedance_);
  }

  /// The stress of tools that move by a displacement or a force is not known.
  void add_tools() {
    for (const input::Tool& tool : setup_.model.tools) {
      if (tool.displacement || tool.force) stress_ = infinity;
      const double speed = norm(tool.velocity.value_or(Vector{})) +
                           norm(tool.angular_velocity.value_or(Vector{})) * norm(farthest_point(tool));
      add({{speed, speed}}, impedance_);
    }
  }

  double stress() const { return stress_; }
  bool is_sudden() const { return is_sudden_; }

private:
  void add(const std::vector<Peak>& components, double stress_per_unit) {
    Peak sum;
    for (const Peak& one : components) {
      sum.early = std::hypot(sum.early, one.early);
      sum.whole = std::hypot(sum.whole, one.whole);
    }
    stress_ += stress_per_unit * sum.whole;
    is_sudden_ = is_sudden_ || (sum.whole > 0 && sum.early >= 0.5 * sum.whole);
  }

  /// Stress per amplitude of a body force, over the length of the body.
  double whole_density(const mechanics::ForcePattern& pattern) const {
    double volume = 0;
    for (const double one : setup_.body.operators().node_volume) volume += one;
    return pattern.total_weight / volume * std::ranges::max(setup_.model.specimen.size);
  }

  /// Traction per amplitude where it is largest.
  double densest_share(const mechanics::ForcePattern& pattern,
                       const geometry::ConditionRegion& region) const {
    if (region.n_dimensions < 2) return infinity;
    const auto whole = mechanics::loaded_region(setup_.group, region, setup_.subdomain);
    double density = 0;
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
      const auto place = std::ranges::lower_bound(whole.nodes, pattern.nodes[i]) - whole.nodes.begin();
      density = std::max(density, std::abs(pattern.weight[i]) / whole.area[index(place)]);
    }
    return density;
  }

  const SampleSetup& setup_;
  double duration_, early_ = 0, impedance_ = 0;
  double stress_ = 0;
  bool is_sudden_ = false;
};

/// Maximum amplification of a stress by reflection, superposition and notches that is assumed possible.
constexpr double wave_amplification = 10;
/// Share of the volume beyond what is strained at notches only.
constexpr double large_part = 0.01;

std::string text_of_load(double load) {
  return quantity_text(std::abs(load), "N");
}

std::string too_late(const input::Time& time, const FirstBreakPrediction& outlook) {
  const double reach = std::max(time.duration, outlook.transit);
  if (!std::isfinite(outlook.time) || outlook.time <= wave_amplification * reach) return {};
  return fmt::format(
      "the loads are far from breaking the body: in equilibrium they reach the first break after {}, at "
      "about {}, but the phase lasts {}; raise the loads or their rate, or set time.start = \"quasi-static\"",
      quantity_text(outlook.time, "s"), text_of_load(outlook.load), quantity_text(time.duration, "s"));
}

}  // namespace

WaveOutlook wave_outlook(const SampleSetup& setup) {
  Waves waves(setup);
  waves.add_forces();
  waves.add_motions();
  waves.add_tools();
  const auto strengths = setup.law.strengths();
  return {waves.stress(), *std::ranges::min_element(strengths), waves.is_sudden()};
}

std::string wave_text(const input::BulkViscosity& viscosity, const WaveOutlook& outlook) {
  if (outlook.stress == 0 || std::isinf(outlook.stress)) return {};
  std::string text = fmt::format(
      "waves of the loads reach about {} (an estimate), up to twice that where they are reflected; "
      "the strength is {} at least",
      quantity_text(outlook.stress, "Pa"), quantity_text(outlook.strength, "Pa"));
  if (outlook.is_sudden && !viscosity.acts())
    text +=
        "; behind a sudden front the stress overshoots by a fifth, in single tetrahedra by a third; "
        "damping.bulk = [0.5, 1.2] leaves none and 15 %";
  return text;
}

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
  outlook.has_contact = loading.cuts_are_closed();
  if (!outlook.breaks) return outlook;
  outlook.share = 1;
  outlook.load = loading.load();
  if (has_broken()) outlook.time = loading.time();
  return outlook;
}

RestOutlook rest_outlook(const input::Model& model, const geometry::Realization& realization, bool solves) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = geometry::split(realization, geometry::partition(realization, 1)).front();
  SampleSetup setup(self, model, subdomain, 0);
  RestOutlook outlook{wave_outlook(setup), {}};
  const bool may_break = wave_amplification * outlook.waves.stress >= outlook.waves.strength;
  // A slow load bends a body at far higher stresses than those of its waves.
  if (!solves || may_break || !setup.free_motions().empty()) return outlook;
  try {
    EnergyAccount account(self, setup.body);
    QuasiStaticLoading loading(setup.motion_context(),
                               arrest_window(model.time, model.specimen.size, setup.waves));
    loading.load_at_start(account);
    outlook.equilibrium = first_break(loading, setup.loads, account);
    outlook.equilibrium->transit = wave_transit(model.specimen.size, setup.waves);
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

std::string weak_load_warning(const input::Time& time, const RestOutlook& outlook) {
  if (wave_amplification * outlook.waves.stress >= outlook.waves.strength) return {};
  const auto& equilibrium = outlook.equilibrium;
  if (equilibrium && equilibrium->breaks) return too_late(time, *equilibrium);
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
