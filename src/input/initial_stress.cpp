// SPDX-License-Identifier: GPL-3.0-or-later
// [[initial.stress]]
#include "consistency.h"
#include "schema.h"

#include "common/interpolation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace crackle::input {

namespace {

/// Share of a profile's largest stress below which its mean and its linear part count as 0.
constexpr double balanced = 1e-6;

template <class T>
Access<T> initial(T InitialStress::*member) {
  return
      [=](Parameters& parameters, std::size_t i) -> T& { return parameters.initial_stresses.at(i).*member; };
}

/// The key, which says what kind of initial stress it is.
Key of_kind(InitialStressKind kind, Key key) {
  key.read = [=, read = key.read](const Source& source, Parameters& parameters, std::size_t i) {
    parameters.initial_stresses.at(i).kind = kind;
    read(source, parameters, i);
  };
  return shown_if(std::move(key), [=](const Parameters& parameters, std::size_t i) {
    return parameters.initial_stresses.at(i).kind == kind;
  });
}

Key components_key() {
  return {"components",
          "words",
          optional("the two across that axis"),
          distinct_axes,
          "the normal stresses of a surface stress or a profile",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            parameters.initial_stresses.at(i).components = read_axes(source);
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const auto& components = parameters.initial_stresses.at(i).components;
            if (!components) return {};
            return show_axes(*components);
          }};
}

Pairs along_axis(const char* value, const Dimension& dimension, const char* example, Range range) {
  return {.argument = "coordinate",
          .value = value,
          .example = example,
          .argument_dimension = length_dimension,
          .argument_range = coordinate,
          .value_dimension = dimension,
          .value_range = range};
}

/// Mean of a profile over an extent, and its linear part: of the straight line that fits it best, the
/// difference from the mean at the upper end [Pa].
struct Residue {
  double mean = 0;
  double linear = 0;
  double largest = 0;  ///< magnitude of the profile
};

Residue residue_of(const InitialStress& stress, const std::pair<double, double>& extent) {
  const double lower = extent.first, upper = extent.second;  // clang 14 captures no structured bindings
  std::vector<double> places{lower};
  for (const auto& [place, value] : stress.profile)
    if (place > lower && place < upper) places.push_back(place);
  places.push_back(upper);
  Residue residue;
  double last = value_at(stress, extent, lower);
  residue.largest = std::abs(last);
  for (std::size_t i = 1; i < places.size(); ++i) {
    // Exact for linear pieces; s runs from -1/2 to 1/2.
    const auto s = [&](double place) { return (place - lower) / (upper - lower) - 0.5; };
    const double a = s(places[i - 1]), b = s(places[i]);
    const double next = value_at(stress, extent, places[i]);
    residue.mean += (b - a) * (last + next) / 2;
    residue.linear += 6 * (b - a) * ((last * a + next * b) / 3 + (last * b + next * a) / 6);
    residue.largest = std::max(residue.largest, std::abs(next));
    last = next;
  }
  return residue;
}

void check_form(const InitialStress& stress, const std::string& key, Findings& findings) {
  std::vector<std::string> given;
  for (const char* kind : {"surface", "profile", "temperature"})
    if (findings.given(key + "." + kind)) given.push_back(kind);
  if (given.size() != 1)
    return findings.report(
        key, "{}; give exactly one of surface, profile and temperature (with expansion)",
        given.empty() ? "has no stress" : fmt::format("has {}", fmt::join(given, " and ")));
  const bool is_thermal = stress.kind == InitialStressKind::temperature;
  if (is_thermal && !findings.given(key + ".expansion"))
    findings.report(key + ".expansion", "the key is missing, but temperature requires it; give {}",
                    quantity_form(expansion_dimension));
  for (const char* name : {"expansion", "material"})
    if (!is_thermal && findings.given(key + "." + name))
      findings.report(key + "." + name, "belongs to temperature; leave it out");
  if (is_thermal && findings.given(key + ".components"))
    findings.report(key + ".components", "belongs to surface or profile; heat expands in all directions");
  else if (stress.components && stress.has(stress.along))
    findings.report(key + ".components",
                    "\"{0}\": a normal stress along {0} that changes along {0} is not in equilibrium",
                    axis_names[index(stress.along)]);
}

void check_balance(const Parameters& parameters, const InitialStress& stress, const std::string& key,
                   Findings& findings) {
  const auto extent = bounds_of(parameters.specimen)[index(stress.along)];
  const Residue residue = residue_of(stress, extent);
  const double allowed = balanced * residue.largest;
  if (std::abs(residue.mean) <= allowed && std::abs(residue.linear) <= allowed) return;
  findings.report(
      key + ".profile",
      "is not in equilibrium: from {0} to {1} its mean is {2:.6g} MPa and its linear part +-{3:.6g} "
      "MPa at the ends; subtract both",
      axis_names[index(stress.along)] + std::string(" = ") + shown_length(extent.first),
      shown_length(extent.second), residue.mean / 1e6, residue.linear / 1e6);
}

}  // namespace

double value_at(const InitialStress& initial, const std::pair<double, double>& extent, double coordinate) {
  if (initial.kind == InitialStressKind::surface) {
    const double s = (coordinate - extent.first) / (extent.second - extent.first);
    return initial.surface * (1 - 6 * s * (1 - s));
  }
  return interpolated(initial.kind == InitialStressKind::profile ? initial.profile : initial.temperature,
                      coordinate);
}

Table initial_stress_table() {
  constexpr Range stress{-1e14, 1e14};
  const std::vector<std::pair<std::string, int>> axes{{"x", 0}, {"y", 1}, {"z", 2}};
  return {
      "initial.stress",
      Occurrence::many,
      "stress from the start, uniform across an axis; several add up, and strain the body until they balance",
      {choice_key<int>("along", initial(&InitialStress::along), axes, required(),
                       "axis along which it changes"),
       of_kind(
           InitialStressKind::surface,
           quantity_key(
               "surface", initial(&InitialStress::surface), with_example(stress_dimension, "-100 MPa"),
               stress, optional("or profile, or temperature"),
               "as in tempered glass: a parabola from this stress at both ends to -1/2 of it in the middle")),
       of_kind(
           InitialStressKind::profile,
           pairs_key("profile", initial(&InitialStress::profile),
                     along_axis("stress", stress_dimension,
                                "[[\"0 mm\", \"-60 MPa\"], [\"1 mm\", \"60 MPa\"], [\"2 mm\", \"-60 MPa\"]]",
                                stress),
                     optional("or surface, or temperature"),
                     "linear between, constant outside; resultant and moment over the body's extent must "
                     "vanish")),
       components_key(),
       of_kind(InitialStressKind::temperature,
               pairs_key("temperature", initial(&InitialStress::temperature),
                         along_axis("change", with_example(temperature_dimension, "-200 K"),
                                    "[[\"0 mm\", \"-200 K\"], [\"1 mm\", \"0 K\"]]", {-1e5, 1e5}),
                         optional("or surface, or profile"),
                         "change of temperature, linear between, constant outside")),
       optional_quantity_key("expansion", initial(&InitialStress::expansion), expansion_dimension, {-1, 1},
                             optional("required with temperature"), "coefficient of thermal expansion")
           .also_called({"alpha", "cte"}),
       text_key("material", initial(&InitialStress::material), optional("all"),
                "the name of a material, such as \"glass\"", "the one that has this expansion"),
       history_key(
           initial(&InitialStress::history),
           "factors, constant during a dynamic phase; for a quench, one "
           "[[initial.stress]] per time, with a history that is 1 then and 0 at the neighbouring times")},
      [](const Parameters& parameters) { return parameters.initial_stresses.size(); },
      [](Parameters& parameters) { parameters.initial_stresses.emplace_back(); }};
}

void check_initial_stresses(const Parameters& parameters, Findings& findings) {
  for (std::size_t i = 0; i < parameters.initial_stresses.size(); ++i) {
    const InitialStress& stress = parameters.initial_stresses[i];
    const std::string key = fmt::format("initial.stress[{}]", i);
    if (parameters.time.start == Start::rest && !findings.faulty("time.start"))
      findings.report(
          key,
          "needs equilibrium first; give time.start = \"quasi-static\", or \"equilibrium\" to start "
          "the dynamic phase at time 0");
    check_form(stress, key, findings);
    if (!stress.material.empty() && !findings.faulty(key + ".material"))
      check_is_named(parameters.materials, stress.material, key + ".material", findings);
    const bool is_known =
        is_box(parameters.specimen) ? size_is_known(findings) : shape_is_known(parameters.specimen, findings);
    if (stress.kind == InitialStressKind::profile && is_known && !parameters.specimen.solid &&
        !findings.faulty(key))
      check_balance(parameters, stress, key, findings);
  }
}

}  // namespace crackle::input
