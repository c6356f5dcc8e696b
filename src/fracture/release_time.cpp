// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/release_time.h"

#include "common/index.h"
#include "common/quantity_text.h"
#include "fracture/toughness.h"
#include "mechanics/elasticity.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace crackle::fracture {

namespace {

/// Share of the tetrahedra that may be released in less than two time steps.
constexpr double few = 0.01;

// Gamma / G = 1 + scale (v / v_r)^rise / (1 - v / c_R)^limit
constexpr double dissipation_scale = 2.26, dissipation_rise = 1.68, dissipation_limit = 1.05;

double usual_release_speed(const input::Material& material) {
  return usual_release_share * mechanics::rayleigh_speed(material);
}

/// A value of each material as a field, or values of each tetrahedron if `differs`.
/// @param value of a tetrahedron and the number of its material
template <class Value>
mechanics::TetrahedronField<double> field_of(const TetrahedronSpan& tetrahedra, bool differs, Value&& value) {
  if (!differs && tetrahedra.material.empty())
    return mechanics::TetrahedronField<double>(value(std::size_t{0}, std::size_t{0}));
  std::vector<double> values;
  values.reserve(tetrahedra.tetrahedra.size());
  for (std::size_t t = 0; t < tetrahedra.tetrahedra.size(); ++t)
    values.push_back(value(t, tetrahedra.material_of(t)));
  return mechanics::TetrahedronField<double>(std::move(values));
}

/// @param spacings returns the local spacings of all tetrahedra; called if any of them matters
template <class Spacings>
mechanics::TetrahedronField<double> release_times_of(const input::MaterialModel& model,
                                                     const TetrahedronSpan& tetrahedra, Spacings&& spacings) {
  std::vector<double> speed, time;  // of each material
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    speed.push_back(release_speed(model, m));
    time.push_back(model.fracture_of(m).release_time.value_or(0));
  }
  const bool differs = std::ranges::any_of(speed, [](double v) { return v > 0; });
  const std::vector<double> spacing = differs ? spacings() : std::vector<double>();
  return field_of(tetrahedra, differs, [&](std::size_t t, std::size_t m) {
    return speed[m] > 0 ? spacing[t] / speed[m] : time[m];
  });
}

}  // namespace

double release_speed(const input::MaterialModel& model, std::size_t material) {
  const input::Fracture fracture = model.fracture_of(material);
  if (fracture.release_speed > 0) return fracture.release_speed;
  const bool is_usual = !fracture.release_time && fracture.toughness > 0 && !fracture.softens();
  return is_usual ? usual_release_speed(model.materials[material]) : 0;
}

mechanics::TetrahedronField<double> release_times(const parallel::Communicator& group,
                                                  const input::MaterialModel& model,
                                                  const BreakableBody& body) {
  return release_times_of(model, span_of(body.subdomain()),
                          [&] { return local_spacings(group, body.subdomain(), body.operators()); });
}

mechanics::TetrahedronField<double> release_times(const input::MaterialModel& model,
                                                  const TetrahedronSpan& tetrahedra) {
  return release_times_of(model, tetrahedra, [&] { return local_spacings(tetrahedra); });
}

void refuse_short_releases(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const mechanics::TetrahedronField<double>& release_times, double time_step) {
  std::array<std::int64_t, 2> n{0, 0};  // tetrahedra released too fast, all
  double shortest = infinity;
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    if (subdomain.owned[index(t)] == 0) continue;
    const double time = release_times[t];
    const bool is_short = time > 0 && time < 2 * time_step;
    n[0] += is_short ? 1 : 0;
    ++n[1];
    if (is_short) shortest = std::min(shortest, time);
  }
  parallel::check_peers(group);
  parallel::all_reduce(group, n, MPI_SUM);
  const double share = static_cast<double>(n[0]) / static_cast<double>(n[1]);
  if (share <= few) return;
  shortest = -parallel::largest_of_all(group, -shortest);
  throw parallel::AgreedError(
      0, fmt::format(
             "{:.3g} % of the tetrahedra would lose their stiffness in less than two time steps of {}, the "
             "first in {}: give a lower release_speed, a longer release_time, or release_time = \"0 s\", "
             "immediate release",
             100 * share, quantity_text(time_step, "s"), quantity_text(shortest, "s")));
}

mechanics::TetrahedronField<double> impulses(const parallel::Communicator& group,
                                             const input::MaterialModel& model, const BreakableBody& body,
                                             const Strengths& strengths) {
  std::vector<double> given, speed;  // of each material
  for (std::size_t m = 0; m < model.materials.size(); ++m) {
    given.push_back(model.fracture_of(m).impulse);
    const double own = release_speed(model, m);
    speed.push_back(own > 0 ? own : usual_release_speed(model.materials[m]));
  }
  const bool differs = std::ranges::any_of(given, [](double impulse) { return impulse == 0; });
  const std::vector<double> spacing =
      differs ? local_spacings(group, body.subdomain(), body.operators()) : std::vector<double>();
  const double exponent = model.fracture.exponent;
  return field_of(span_of(body.subdomain()), differs, [&](std::size_t t, std::size_t m) {
    if (given[m] > 0) return given[m];
    const double over =
        inert_overload * (strengths.growth.empty() ? strengths.nucleation[t] : strengths.growth[t]);
    return (exponent == 2 ? over * over : std::pow(over, exponent)) * spacing[t] / speed[m];
  });
}

double dissipation_ratio(double speed, double release_speed, double rayleigh_speed) {
  return 1 + dissipation_scale * std::pow(speed / release_speed, dissipation_rise) /
                 std::pow(1 - speed / rayleigh_speed, dissipation_limit);
}

double driven_crack_speed(double release_speed, double rayleigh_speed) {
  double lower = 0, upper = rayleigh_speed;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (lower + upper);
    (dissipation_ratio(middle, release_speed, rayleigh_speed) < usual_drive ? lower : upper) = middle;
  }
  return lower;
}

double release_speed_for(double crack_speed, double rayleigh_speed) {
  // Gamma / G - 1 is proportional to a power of 1 / v_r.
  const double excess = dissipation_ratio(crack_speed, crack_speed, rayleigh_speed) - 1;
  return crack_speed * std::pow(excess / (usual_drive - 1), 1 / dissipation_rise);
}

}  // namespace crackle::fracture
