// SPDX-License-Identifier: GPL-3.0-or-later
#include "dimension.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

namespace crackle::input {

const Dimension length_dimension{
    "a length", "m", "1.0 mm", 0, {{"km", 1e3}, {"m", 1}, {"mm", 1e-3, 1e-5}, {"um", 1e-6}, {"nm", 1e-9}}};
const Dimension time_dimension{
    "a time",
    "s",
    "5 ns",
    0,
    {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}, {"ps", 1e-12}, {"fs", 1e-15}}};
const Dimension stress_dimension{
    "a stress", "Pa", "35 MPa", 0, {{"GPa", 1e9, 1e11}, {"MPa", 1e6}, {"kPa", 1e3}, {"Pa", 1}}};
const Dimension density_dimension{"a density", "kg/m^3", "1180 kg/m^3", 0, {{"kg/m^3", 1}}};
const Dimension energy_per_area_dimension{
    "an energy per area", "J/m^2", "3 J/m^2", 0, {{"kJ/m^2", 1e3, 1e4}, {"J/m^2", 1}}};

const Dimension volume_dimension{
    "a volume", "m^3", "1 mm^3", 0, {{"m^3", 1}, {"cm^3", 1e-6, 1e-5}, {"mm^3", 1e-9}, {"um^3", 1e-18}}};

const Dimension stress_intensity_dimension{
    "a stress intensity", "Pa m^0.5", "1 MPa m^0.5", 0, {{"MPa m^0.5", 1e6, 1e3}, {"Pa m^0.5", 1}}, "Pa^2 m"};

const Dimension rate_of_decay_dimension{
    "a rate", "1/s", "500 1/s", 0, {{"1/us", 1e6}, {"1/ms", 1e3, 1e5}, {"1/s", 1}}};

const Dimension angle_dimension{"an angle", "radian", "30 degree", 0, {{"degree", std::numbers::pi / 180}}};

const Dimension temperature_dimension{"a change of temperature", "K", "-200 K", 0, {{"K", 1}, {"mK", 1e-3}}};

const Dimension expansion_dimension{"an expansion", "1/K", "8e-6 1/K", 0, {{"1/K", 1, 1e-30}}};
const Dimension acceleration_dimension{
    "an acceleration", "m/s^2", "-9.81 m/s^2", 0, {{"m/s^2", 1}, {"mm/s^2", 1e-3}}};
const Dimension acceleration_rate_dimension{
    "an acceleration per time", "m/s^3", "100 m/s^3", 0, {{"m/s^3", 1}, {"mm/s^3", 1e-3}}};
const Dimension body_force_dimension{
    "a force per volume", "N/m^3", "-25 kN/m^3", 0, {{"kN/m^3", 1e3}, {"N/m^3", 1}}};
const Dimension body_force_rate_dimension{
    "a force per volume and time", "N/m^3/s", "10 kN/m^3/s", 0, {{"kN/m^3/s", 1e3}, {"N/m^3/s", 1}}};
const Dimension angular_velocity_dimension{"an angular velocity", "rad/s", "3000 rpm", 0, {{"rad/s", 1}}};
const Dimension number_density_dimension{
    "a number per volume", "m-3", "0.1 mm-3", 0, {{"mm-3", 1e9}, {"m-3", 1}}};
const Dimension mass_dimension{"a mass", "kg", "5 g", 0, {{"kg", 1}, {"g", 1e-3}, {"mg", 1e-6}}};
const Dimension share_dimension{"a share", "1", "0.2 %", 0, {{"%", 1e-2}}};
const Dimension velocity_gradient_dimension = with_example(rate_of_decay_dimension, "5000 1/s");

Dimension impulse_dimension(double exponent) {
  const std::string power = exponent == 1 ? std::string() : fmt::format("^{}", format_number(exponent));
  const std::string unit = fmt::format("MPa{} s", power);
  return {exponent == 1 ? "a stress times a time" : fmt::format("a stress{} times a time", power),
          fmt::format("Pa{} s", power),
          "1e-8 " + unit,
          exponent,
          {{unit, std::pow(1e6, exponent)}}};
}

const Dimension& value_dimension(BoundaryKind kind) {
  static const std::map<BoundaryKind, Dimension> dimensions{
      {BoundaryKind::force, {"a force", "N", "135 N", 0, {{"N", 1}, {"mN", 1e-3}}}},
      {BoundaryKind::traction, stress_dimension},
      {BoundaryKind::velocity, {"a velocity", "m/s", "0.1 m/s", 0, {{"m/s", 1}, {"mm/s", 1e-3}}}},
      {BoundaryKind::displacement, with_example(length_dimension, "0.1 mm")},
      {BoundaryKind::pressure, with_example(stress_dimension, "2 MPa")}};
  return dimensions.at(kind);
}

const Dimension& rate_dimension(BoundaryKind kind) {
  static const Dimension stress_rate{
      "a stress per time", "Pa/s", "1 MPa/s", 0, {{"MPa/s", 1e6}, {"kPa/s", 1e3}, {"Pa/s", 1}}};
  static const std::map<BoundaryKind, Dimension> dimensions{
      {BoundaryKind::force, {"a force per time", "N/s", "5 N/s", 0, {{"N/s", 1}, {"mN/s", 1e-3}}}},
      {BoundaryKind::traction, stress_rate},
      {BoundaryKind::pressure, stress_rate},
      {BoundaryKind::velocity, {"an acceleration", "m/s^2", "1 m/s^2", 0, {{"m/s^2", 1}, {"mm/s^2", 1e-3}}}},
      {BoundaryKind::displacement,
       {"a displacement per time", "m/s", "0.01 mm/s", 0, {{"m/s", 1}, {"mm/s", 1e-3}, {"um/s", 1e-6}}}}};
  return dimensions.at(kind);
}

std::vector<Dimension> known_dimensions(double exponent) {
  std::vector<Dimension> dimensions{length_dimension,
                                    time_dimension,
                                    stress_dimension,
                                    density_dimension,
                                    energy_per_area_dimension,
                                    volume_dimension,
                                    rate_of_decay_dimension,
                                    stress_intensity_dimension,
                                    temperature_dimension,
                                    expansion_dimension,
                                    acceleration_dimension,
                                    body_force_dimension,
                                    angular_velocity_dimension,
                                    acceleration_rate_dimension,
                                    body_force_rate_dimension,
                                    mass_dimension,
                                    share_dimension,
                                    angle_dimension,
                                    number_density_dimension};
  for (const BoundaryTraits& traits : boundary_kinds) {
    if (!has_quantity(traits.kind)) continue;
    dimensions.push_back(value_dimension(traits.kind));
    dimensions.push_back(rate_dimension(traits.kind));
  }
  if (exponent != 0) dimensions.push_back(impulse_dimension(exponent));
  return dimensions;
}

Dimension with_example(Dimension dimension, std::string example) {
  dimension.example = std::move(example);
  return dimension;
}

std::string format_number(double value) {
  // Ten digits hide the rounding of unit conversions; a number with more significant digits is shown in full.
  const std::string text = fmt::format("{:.10g}", value);
  double rounded = 0;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  constexpr double conversion = 8 * std::numeric_limits<double>::epsilon();
  if (std::abs(rounded - value) <= conversion * std::abs(value)) return text;
  return fmt::format("{:.16g}", value);
}

std::string format_quantity(double value, const Dimension& dimension) {
  // A unit still fits a value that is slightly below 1 due to rounding.
  constexpr double rounding = 1e-12;
  const ReadableUnit* unit = &dimension.units.back();
  for (const ReadableUnit& candidate : dimension.units) {
    const double from = candidate.from > 0 ? candidate.from : candidate.factor;
    if (std::abs(value) >= from * (1 - rounding) || (value == 0 && candidate.factor == 1)) {
      unit = &candidate;
      break;
    }
  }
  return format_number(value / unit->factor) + " " + unit->name;
}

std::string show(double length) {
  return format_quantity(length, length_dimension);
}

std::string shown_length(double length) {
  return length == 0 ? "0 mm" : show(length);
}

}  // namespace crackle::input
