// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/wave_outlook.h"

#include "crackle/common/index.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/real.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/condition_region.h"
#include "crackle/input/plausibility.h"
#include "crackle/mechanics/elasticity.h"

#include "mechanics/loaded_region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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
  explicit Waves(const SampleSetup& setup) : setup_(setup), duration_(setup.parameters.time.duration) {
    const auto& parameters = setup.parameters;
    early_ = std::min(duration_,
                      spacings_of_a_front * parameters.mesh.finest_spacing() / setup.waves.dilatational);
    const auto& material = setup.body.material();
    for (std::int32_t t = 0; t < setup.subdomain.n_tetrahedra(); ++t) {
      const double density = material.density[t];
      impedance_ =
          std::max(impedance_, density * mechanics::dilatational_speed(material.elasticity[t], density));
    }
  }

  void add_forces() {
    const auto& parameters = setup_.parameters;
    const auto body = geometry::make_body(parameters);
    const auto regions = geometry::condition_regions(*body, parameters.boundaries);
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
    const double speed = input::initial_speed(setup_.parameters, is_free);
    add({{speed, speed}}, impedance_);
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
    return pattern.total_weight / volume * std::ranges::max(setup_.parameters.specimen.size);
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

}  // namespace

WaveOutlook wave_outlook(const SampleSetup& setup) {
  Waves waves(setup);
  waves.add_forces();
  waves.add_motions();
  const auto strengths = setup.criterion->strengths();
  return {waves.stress(), *std::ranges::min_element(strengths), waves.is_sudden()};
}

std::string wave_text(const input::Parameters& parameters, const WaveOutlook& outlook) {
  if (outlook.stress == 0 || std::isinf(outlook.stress)) return {};
  std::string text = fmt::format(
      "waves of the loads reach about {} (an estimate), up to twice that where they are reflected; "
      "the strength is {} at least",
      quantity_text(outlook.stress, "Pa"), quantity_text(outlook.strength, "Pa"));
  if (outlook.is_sudden && !parameters.bulk_viscosity().acts())
    text +=
        "; behind a sudden front the stress overshoots by a fifth, in single tetrahedra by a third; "
        "damping.bulk = [0.5, 1.2] leaves none and 15 %";
  return text;
}

}  // namespace crackle::dynamics
