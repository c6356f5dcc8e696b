// SPDX-License-Identifier: GPL-3.0-or-later
#include "input/plausibility.h"

#include "common/interpolation.h"
#include "common/quantity_text.h"
#include "common/real.h"
#include "consistency.h"
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
/// The radius of the ball over which a stress is averaged has the strength of about as many spacings.
constexpr double spacings_per_radius = 3;
/// With strengths below this share of Young's modulus a body breaks under its own weight.
constexpr double least_strength = 1e-7;
constexpr double many_transits = 1000;
/// Share of the duration that is long for a break, or for a tetrahedron to lose its stiffness.
constexpr double long_share = 0.1;
/// Velocities above this share of a wave's speed strain the body by as much.
constexpr double fast_share = 0.01;
/// A reference volume above so many of the body's.
constexpr double many_bodies = 1000;
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

std::string of_modulus(const Model& model, std::size_t number) {
  const double modulus = model.materials[number].youngs_modulus;
  const std::string key = material_key(model.materials, number);
  if (modulus < softest)
    return fmt::format("{}.youngs_modulus = {} is softer than rubber, like a gel{}", key,
                       shown_stress(modulus), mega_is_meant(modulus, 100 * softest, stiffest));
  if (modulus > stiffest)
    return fmt::format("{}.youngs_modulus = {} is stiffer than diamond", key, shown_stress(modulus));
  return {};
}

std::string of_density(const Model& model, std::size_t number) {
  const double density = model.materials[number].density;
  if (density >= lightest && density <= heaviest) return {};
  const double meant = 1000 * density;
  return fmt::format(
      "{}.density = {:.4g} kg/m^3 is {} than any solid{}", material_key(model.materials, number), density,
      density < lightest ? "lighter" : "heavier",
      density < lightest && meant <= heaviest
          ? fmt::format("; did you mean {:.4g} g/cm^3, which is {:.4g} kg/m^3?", density, meant)
          : "");
}

/// Key of a material's value: that of the material or that of [fracture].
std::string key_of(const Model& model, std::size_t number, double own, const char* name) {
  return fmt::format("{}.{}", own > 0 ? material_key(model.materials, number) : "fracture", name);
}

/// What is wrong with strains of a tenth and more.
std::string over_a_tenth(double strength, double modulus) {
  std::string text = fmt::format("more than a tenth of Young's modulus, {}, ", shown_stress(modulus));
  if (modulus >= brittle_modulus) return text + "which no solid sustains";
  text += "beyond the small strains that the program assumes";
  const double meant = 1000 * modulus;
  return strength > ideal_strength * meant
             ? text
             : text + fmt::format("; did you mean a modulus of {}?", shown_stress(meant));
}

std::string of_strength(double strength, double modulus, const std::string& key) {
  if (strength > ideal_strength * modulus)
    return fmt::format("{} = {} is {}", key, shown_stress(strength), over_a_tenth(strength, modulus));
  if (strength > 0 && strength < least_strength * modulus)
    return fmt::format("{} = {} is {:.2g} of Young's modulus{}", key, shown_stress(strength),
                       strength / modulus,
                       mega_is_meant(strength, least_strength * modulus, ideal_strength * modulus));
  return {};
}

std::string of_strength(const Model& model, std::size_t number) {
  const Material& material = model.materials[number];
  return of_strength(model.fracture_of(number).strength, material.youngs_modulus,
                     key_of(model, number, material.strength, "strength"));
}

/// A toughness corresponds to a strength of about sqrt(toughness * modulus / spacing), highest where the mesh
/// is finest.
/// @param given the key and its value, such as "fracture.toughness = 90 J/m^2"
std::string of_toughness(const Model& model, double toughness, double modulus, const std::string& given,
                         const char* units) {
  const double radius = model.fracture.length;
  const auto strength_at = [&](double spacing) {
    return std::sqrt(toughness * modulus / (radius > 0 ? spacings_per_radius * radius : spacing));
  };
  const auto where = [&](double spacing) {
    return radius > 0 ? fmt::format("with an averaging length of {}", show(radius))
                      : fmt::format("at a spacing of {}", show(spacing));
  };
  const double finest = model.mesh.finest_spacing(), coarsest = model.mesh.spacing;
  if (const double strength = strength_at(finest); strength > ideal_strength * modulus)
    return fmt::format("{} needs stresses of about {} {}, {}{}", given, shown_stress(strength), where(finest),
                       over_a_tenth(strength, modulus),
                       modulus >= brittle_modulus ? fmt::format("; {}", units) : "");
  if (const double strength = strength_at(coarsest); strength < least_strength * modulus)
    return fmt::format("{} corresponds to stresses of about {} {}, {:.2g} of Young's modulus", given,
                       shown_stress(strength), where(coarsest), strength / modulus);
  return {};
}

constexpr const char* units_of_toughness = "1 J/mm^2 is a million J/m^2, 1 N/mm a thousand";

std::string of_toughness(const Model& model, std::size_t number) {
  const Fracture fracture = model.fracture_of(number);
  const Material& material = model.materials[number];
  if (fracture.toughness == 0 || fracture.softens()) return {};
  const double own_intensity = material.fracture_toughness;
  const double intensity = own_intensity > 0        ? own_intensity
                           : material.toughness > 0 ? 0
                                                    : fracture.fracture_toughness;
  const bool by_intensity = intensity > 0;
  const std::string given =
      by_intensity ? fmt::format("{} = {}", key_of(model, number, own_intensity, "fracture_toughness"),
                                 format_quantity(intensity, stress_intensity_dimension))
                   : fmt::format("{} = {}", key_of(model, number, material.toughness, "toughness"),
                                 quantity_text(fracture.toughness, "J/m^2"));
  return of_toughness(model, fracture.toughness, material.youngs_modulus, given,
                      by_intensity ? "1 MPa m^0.5 is 31.6 N/mm^1.5" : units_of_toughness);
}

/// @param add receives the warnings
template <class Add>
void look_at_interface(const Model& model, std::size_t number, Add&& add) {
  const Interface& interface = model.interfaces[number];
  const std::string key = fmt::format("interface[{}]", number);
  double modulus = infinity;  // of the softer material
  const auto pair = model.interface_pairs()[number];
  for (const int m : pair)
    modulus = std::min(modulus, model.materials[static_cast<std::size_t>(m)].youngs_modulus);
  add(of_strength(interface.strength, modulus, key + ".strength"));
  if (interface.toughness > 0 && !model.fracture.softens())
    add(of_toughness(model, interface.toughness, modulus,
                     fmt::format("{}.toughness = {}", key, quantity_text(interface.toughness, "J/m^2")),
                     units_of_toughness));
}

/// Under a stress of twice the strength a tetrahedron breaks after impulse / strength^exponent.
std::string of_impulse(const Model& model, std::size_t number) {
  const Fracture fracture = model.fracture_of(number);
  const Material& material = model.materials[number];
  if (fracture.accumulation == Accumulation::step) return {};
  const double spacing = model.mesh.finest_spacing();
  const double strength =
      fracture.strength > 0
          ? fracture.strength
          : std::sqrt(fracture.toughness * material.youngs_modulus /
                      (fracture.length > 0 ? spacings_per_radius * fracture.length : spacing));
  const double delay = fracture.impulse / std::pow(strength, fracture.exponent);
  const double duration = model.time.duration;
  if (!(delay > long_share * duration)) return {};
  return fmt::format(
      "{} = {} keeps a tetrahedron from breaking for {} at twice its strength of about {}, with a "
      "time.duration of {}: usual impulses are far below 1 % of strength^exponent times the duration",
      key_of(model, number, material.impulse, "impulse"),
      format_quantity(fracture.impulse, impulse_dimension(fracture.exponent)), quantity_text(delay, "s"),
      shown_stress(strength), quantity_text(duration, "s"));
}

std::string of_duration(const Model& model) {
  const double speed = slowest_bar_speed(model.materials);
  const Vector& size = model.specimen.size;
  const double transit = std::ranges::max(size) / speed;
  const double duration = model.time.duration;
  if (duration > many_transits * transit)
    return fmt::format("time.duration = {} is {:.2g} times the transit time of a wave along the body, {}{}",
                       quantity_text(duration, "s"), duration / transit, quantity_text(transit, "s"),
                       duration >= 1000 ? "; Ms is megasecond, ms millisecond, us microsecond" : "");
  // From rest a wave may break the body on its way through the thickness.
  const double across = std::min(size[1], size[2]);
  const double way = model.time.start == Start::rest ? std::min(size[0], across) : across;
  if (duration < way / speed)
    return fmt::format(
        "time.duration = {} is shorter than a wave takes across {} of the body, {}, and cracks are slower",
        quantity_text(duration, "s"), show(way), quantity_text(way / speed, "s"));
  return {};
}

/// The largest velocity that a condition prescribes during a phase that starts from rest [m/s].
double prescribed_speed(const Boundary& condition, double duration) {
  const bool is_velocity = condition.kind == BoundaryKind::velocity;
  if (!is_velocity && condition.kind != BoundaryKind::displacement) return 0;
  double speed = norm(condition.rate);
  if (is_velocity)
    for (const double time : {0.0, duration})
      speed = std::max(speed, norm(condition.value + time * condition.rate));
  double largest = condition.history.empty() ? 1 : 0;
  for (std::size_t i = 0; i < condition.history.size(); ++i) {
    const auto& [time, factor] = condition.history[i];
    if (is_velocity && (i == 0 || condition.history[i - 1].first < duration))
      largest = std::max(largest, std::abs(factor));
    if (is_velocity || i == 0) continue;
    const auto& [before, last] = condition.history[i - 1];
    if (before >= duration) break;
    speed = std::max(speed, norm(condition.value) * std::abs(factor - last) / (time - before));
  }
  if (is_velocity && !condition.history.empty()) speed = norm(condition.value) * largest;
  return speed * (condition.factor ? condition.factor->largest_magnitude() : 1);
}

/// Displacements from rest that are not 0 at time 0: nodes jump in no time, by strains over one spacing.
std::string of_jump(const Model& model) {
  if (model.time.start != Start::rest) return {};
  for (std::size_t i = 0; i < model.boundaries.size(); ++i) {
    const Boundary& condition = model.boundaries[i];
    const double factor = condition.history.empty() ? 1 : interpolated(condition.history, 0);
    if (condition.kind != BoundaryKind::displacement || norm(condition.value) * factor == 0) continue;
    return fmt::format(
        "boundary[{}] is displaced by {} at time 0 already, in no time, with stresses that follow the "
        "spacing; give a rate or a history from 0 on, or time.start = \"equilibrium\"",
        i, quantity_text(norm(condition.value) * std::abs(factor), "m"));
  }
  return {};
}

std::string of_release_time(const Model& model) {
  double release = 0;
  for (std::size_t i = 0; i < model.materials.size(); ++i) {
    const Fracture fracture = model.fracture_of(i);
    release =
        std::max(release, fracture.release_speed > 0 ? model.mesh.finest_spacing() / fracture.release_speed
                                                     : fracture.release_time.value_or(0));
  }
  const double duration = model.time.duration;
  if (!(release > long_share * duration)) return {};
  return fmt::format(
      "a release in {} is more than a tenth of time.duration = {}: few tetrahedra lose all of their "
      "stiffness; give a shorter release_time, or a higher release_speed",
      quantity_text(release, "s"), quantity_text(duration, "s"));
}

/// Velocities from rest that strain the body by more than small strains: a wave strains by velocity over
/// wave speed. A body in free flight is not strained.
std::string of_speed(const Model& model) {
  if (model.time.start != Start::rest) return {};
  double speed = 0;
  bool is_held = false;
  for (const Boundary& condition : model.boundaries) {
    is_held = is_held || prescribes_motion(condition.kind);
    speed = std::max(speed, prescribed_speed(condition, model.time.duration));
  }
  const bool is_strained = is_held || std::ranges::any_of(model.loads, [](const BodyLoad& load) {
                             return load.kind == LoadKind::velocity_gradient;
                           });
  if (is_strained) speed = std::max(speed, initial_speed(model));
  const double wave = slowest_bar_speed(model.materials);
  if (!(speed > fast_share * wave)) return {};
  return fmt::format(
      "a velocity of {} is {:.2g} % of a wave's, {}: it strains the body by as much, beyond the small "
      "strains that the program assumes",
      quantity_text(speed, "m/s"), 100 * speed / wave, quantity_text(wave, "m/s"));
}

std::string of_reference_volume(const Model& model) {
  const auto& variation = model.fracture.variation;
  const Vector& size = model.specimen.size;
  const double body = size[0] * size[1] * size[2];
  if (!variation || variation->reference_volume == 0) return {};
  if (variation->correlation_length > 0)
    return "fracture.variation.reference_volume has no effect beside correlation_length: leave one of them "
           "out";
  if (!(variation->reference_volume > many_bodies * body)) return {};
  return fmt::format(
      "fracture.variation.reference_volume = {} is {:.2g} times the body's {}: the body is then {:.2g} times "
      "as strong as such a volume",
      format_quantity(variation->reference_volume, volume_dimension), variation->reference_volume / body,
      format_quantity(body, volume_dimension),
      std::pow(variation->reference_volume / body, 1 / variation->modulus));
}

std::string of_output(const Output& output, const Time& time) {
  const auto& history = output.history;
  if (!history || *history <= time.duration) return {};
  return fmt::format("output.history = {} is longer than time.duration = {}", quantity_text(*history, "s"),
                     quantity_text(time.duration, "s"));
}

/// A material or an interface that is nowhere in the body.
std::string of_use(const Model& model) {
  if (model.map && model.map->of == MapOf::material) return {};
  const auto is_used = [&](const std::string& name) {
    return name == model.material().name ||
           std::ranges::find(model.specimen.regions, name, &plane::MaterialRegion::material) !=
               model.specimen.regions.end();
  };
  for (const Material& material : model.materials)
    if (!is_used(material.name))
      return fmt::format("no [[specimen.region]] consists of the material \"{}\"", material.name);
  return {};
}

}  // namespace

double initial_speed(const Model& model, bool is_free) {
  const plane::Region bounds = bounds_of(model.specimen);
  const auto velocities = model.initial_velocities();
  const auto velocity_at = [&](const Vector& p) {
    Vector sum{};
    for (const auto& velocity : velocities) sum = sum + velocity.at(p);
    return sum;
  };
  Vector middle{};
  for (std::size_t k = 0; k < 3; ++k) middle[k] = (bounds[k].first + bounds[k].second) / 2;
  const Vector reference = is_free ? velocity_at(middle) : Vector{};
  double speed = 0;
  // A velocity that is linear in the coordinates is largest at a corner.
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vector p{};
    for (std::size_t k = 0; k < 3; ++k) p[k] = (corner >> k & 1u) != 0 ? bounds[k].second : bounds[k].first;
    speed = std::max(speed, norm(velocity_at(p) - reference));
  }
  return speed;
}

std::vector<std::string> plausibility_warnings(const Study& study) {
  std::vector<std::string> warnings;
  // What follows from a doubtful value is not judged.
  const auto add = [&](std::string text) {
    if (text.empty()) return false;
    if (std::ranges::find(warnings, text) == warnings.end()) warnings.push_back(std::move(text));
    return true;
  };
  bool moves_as_meant = true;
  for (std::size_t i = 0; i < study.materials.size(); ++i) {
    const bool is_soft = add(of_modulus(study, i)), is_light = add(of_density(study, i));
    const bool is_strong = !is_soft && add(of_strength(study, i));
    const bool is_tough = !is_soft && add(of_toughness(study, i));
    const bool is_doubtful = is_soft || is_strong || is_tough;
    if (!is_doubtful) add(of_impulse(study, i));
    moves_as_meant = moves_as_meant && !is_doubtful && !is_light;
  }
  for (std::size_t i = 0; i < study.interfaces.size(); ++i) look_at_interface(study, i, add);
  if (moves_as_meant)
    for (const auto warning_on : {of_duration, of_speed}) add(warning_on(study));
  for (const auto warning_on : {of_jump, of_release_time, of_reference_volume}) add(warning_on(study));
  add(of_output(study.output, study.time));
  add(of_use(study));
  for (std::string& text : section_warnings(study)) add(std::move(text));
  for (std::string& text : idle_load_warnings(study)) add(std::move(text));
  return warnings;
}

}  // namespace crackle::input
