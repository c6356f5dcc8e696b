// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/input/plausibility.h"

#include "consistency.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/real.h"
#include "dimension.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crackle::input {

namespace {

constexpr double softest = 1e6, stiffest = 2e12;   // Young's moduli: of rubber, of diamond [Pa]
constexpr double lightest = 10, heaviest = 23000;  // densities: of foams, of osmium [kg/m^3]
/// Maximum strength of atomic bonds, relative to Young's modulus.
constexpr double ideal_strength = 0.1;
/// Softer materials are gels and rubbers, which stretch far before failing [Pa].
constexpr double brittle_modulus = 1e8;
/// With strengths below this share of Young's modulus a body breaks under its own weight.
constexpr double least_strength = 1e-7;
constexpr double many_transits = 1000;
/// Factor of a mix-up of "m" and "M".
constexpr double milli_for_mega = 1e9;

std::string shown_stress(double stress) {
  return quantity_text(stress, "Pa");
}

/// ": is 32 GPa meant, with MPa for mPa?" if that is plausible; otherwise empty.
std::string mega_is_meant(double stress, double least, double greatest) {
  const double meant = stress * milli_for_mega;
  if (meant < least || meant > greatest) return {};
  return fmt::format("; did you mean {}? mPa is millipascal, MPa megapascal", shown_stress(meant));
}

std::string of_modulus(const Parameters& parameters, std::size_t number) {
  const double modulus = parameters.materials[number].youngs_modulus;
  const std::string key = material_key(parameters.materials, number);
  if (modulus < softest)
    return fmt::format("{}.youngs_modulus = {} is softer than rubber, like a gel{}", key,
                       shown_stress(modulus), mega_is_meant(modulus, 100 * softest, stiffest));
  if (modulus > stiffest)
    return fmt::format("{}.youngs_modulus = {} is stiffer than diamond", key, shown_stress(modulus));
  return {};
}

std::string of_density(const Parameters& parameters, std::size_t number) {
  const double density = parameters.materials[number].density;
  if (density >= lightest && density <= heaviest) return {};
  const double meant = 1000 * density;
  return fmt::format(
      "{}.density = {:.4g} kg/m^3 is {} than any solid{}", material_key(parameters.materials, number),
      density, density < lightest ? "lighter" : "heavier",
      density < lightest && meant <= heaviest
          ? fmt::format("; did you mean {:.4g} g/cm^3, which is {:.4g} kg/m^3?", density, meant)
          : "");
}

/// Key of a material's value: that of the material or that of [fracture].
std::string key_of(const Parameters& parameters, std::size_t number, double own, const char* name) {
  return fmt::format("{}.{}", own > 0 ? material_key(parameters.materials, number) : "fracture", name);
}

std::string of_strength(const Parameters& parameters, std::size_t number) {
  const double strength = parameters.fracture_of(number).strength;
  const Material& material = parameters.materials[number];
  const double modulus = material.youngs_modulus;
  const std::string key = key_of(parameters, number, material.strength, "strength");
  if (modulus >= brittle_modulus && strength > ideal_strength * modulus)
    return fmt::format("{} = {} is more than a tenth of Young's modulus, {}, which no solid sustains", key,
                       shown_stress(strength), shown_stress(modulus));
  if (strength > 0 && strength < least_strength * modulus)
    return fmt::format("{} = {} is {:.2g} of Young's modulus{}", key, shown_stress(strength),
                       strength / modulus,
                       mega_is_meant(strength, least_strength * modulus, ideal_strength * modulus));
  return {};
}

/// A toughness corresponds to a strength of about sqrt(toughness * modulus / spacing).
std::string of_toughness(const Parameters& parameters, std::size_t number) {
  const Fracture fracture = parameters.fracture_of(number);
  const Material& material = parameters.materials[number];
  const double modulus = material.youngs_modulus;
  if (fracture.toughness == 0 || fracture.strength > 0 || modulus < brittle_modulus) return {};
  const double strength = std::sqrt(fracture.toughness * modulus / parameters.mesh.spacing);
  const double own_intensity = material.fracture_toughness;
  const double intensity = own_intensity > 0        ? own_intensity
                           : material.toughness > 0 ? 0
                                                    : fracture.fracture_toughness;
  const bool by_intensity = intensity > 0;
  const std::string given =
      by_intensity ? fmt::format("{} = {}", key_of(parameters, number, own_intensity, "fracture_toughness"),
                                 format_quantity(intensity, stress_intensity_dimension))
                   : fmt::format("{} = {}", key_of(parameters, number, material.toughness, "toughness"),
                                 quantity_text(fracture.toughness, "J/m^2"));
  if (strength > ideal_strength * modulus)
    return fmt::format(
        "{} needs stresses of about {} at a spacing of {}, more than a tenth of Young's modulus, which no "
        "solid sustains; {}",
        given, shown_stress(strength), show(parameters.mesh.spacing),
        by_intensity ? "1 MPa m^0.5 is 31.6 N/mm^1.5" : "1 J/mm^2 is a million J/m^2, 1 N/mm a thousand");
  if (strength < least_strength * modulus)
    return fmt::format("{} corresponds to stresses of about {} at a spacing of {}, {:.2g} of Young's modulus",
                       given, shown_stress(strength), show(parameters.mesh.spacing), strength / modulus);
  return {};
}

std::string of_duration(const Parameters& parameters) {
  const double transit = std::ranges::max(parameters.specimen.size) / slowest_bar_speed(parameters.materials);
  const double duration = parameters.time.duration;
  if (!(duration > many_transits * transit)) return {};
  return fmt::format("time.duration = {} is {:.2g} times the transit time of a wave along the body, {}{}",
                     quantity_text(duration, "s"), duration / transit, quantity_text(transit, "s"),
                     duration >= 1000 ? "; Ms is megasecond, ms millisecond, us microsecond" : "");
}

std::string of_release_time(const Parameters& parameters) {
  double release = 0;
  for (std::size_t i = 0; i < parameters.materials.size(); ++i)
    release = std::max(release, parameters.fracture_of(i).release_time);
  const double duration = parameters.time.duration;
  if (!(release > 0.1 * duration)) return {};
  return fmt::format(
      "a release_time of {} is more than a tenth of time.duration = {}: few tetrahedra lose all of their "
      "stiffness",
      quantity_text(release, "s"), quantity_text(duration, "s"));
}

/// A material or an interface that is nowhere in the body.
std::string of_use(const Parameters& parameters) {
  if (parameters.map && parameters.map->of == MapOf::material) return {};
  const auto is_used = [&](const std::string& name) {
    return name == parameters.material().name ||
           std::ranges::find(parameters.specimen.regions, name, &MaterialRegion::material) !=
               parameters.specimen.regions.end();
  };
  for (const Material& material : parameters.materials)
    if (!is_used(material.name))
      return fmt::format("no [[specimen.region]] consists of the material \"{}\"", material.name);
  return {};
}

}  // namespace

std::vector<std::string> plausibility_warnings(const Parameters& parameters) {
  std::vector<std::string> warnings;
  const auto add = [&](std::string text) {
    if (!text.empty() && std::ranges::find(warnings, text) == warnings.end())
      warnings.push_back(std::move(text));
  };
  for (std::size_t i = 0; i < parameters.materials.size(); ++i)
    for (const auto warning_on : {of_modulus, of_density, of_strength, of_toughness})
      add(warning_on(parameters, i));
  for (const auto warning_on : {of_duration, of_release_time, of_use}) add(warning_on(parameters));
  return warnings;
}

}  // namespace crackle::input
