// SPDX-License-Identifier: GPL-3.0-or-later
// Consistency of materials and interfaces.
#include "input/poisson_limits.h"

#include "consistency.h"
#include "dimension.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <set>

namespace crackle::input {

namespace {

void check_names(const std::vector<Material>& materials, Findings& findings) {
  if (findings.given("material.name"))
    return findings.report("material.name",
                           "a single [material] has no name; write [[material]], in double brackets");
  if (!findings.given("material[0]")) {
    for (const char* const key :
         {"strength", "toughness", "fracture_toughness", "impulse", "release_time", "release_speed"})
      if (findings.given(fmt::format("material.{}", key)))
        findings.report(fmt::format("material.{}", key),
                        "unknown key of a single material; did you mean fracture.{}?", key);
    return;
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const std::string key = fmt::format("material[{}].name", i);
    if (findings.faulty(key)) continue;
    if (!findings.given(key))
      findings.report(key, "the key is missing; give each [[material]] a name");
    else if (!names.insert(materials[i].name).second)
      findings.report(key, "\"{}\" is the name of another material already", materials[i].name);
  }
}

std::string names_of(const std::vector<Material>& materials) {
  std::vector<std::string> names;
  for (const Material& material : materials) names.push_back(fmt::format("\"{}\"", material.name));
  return fmt::format("{}", fmt::join(names, ", "));
}

void check_stiffness_variation(const Parameters& parameters, std::size_t i, Findings& findings) {
  const StiffnessVariation& variation = *parameters.materials[i].variation;
  const std::string table = material_key(parameters.materials, i) + ".variation";
  const bool is_weibull = variation.distribution == Distribution::weibull;
  const char* const name = is_weibull ? "weibull" : "lognormal";
  const std::string needed = is_weibull ? "modulus" : "coefficient_of_variation";
  const std::string useless = is_weibull ? "coefficient_of_variation" : "modulus";
  if (!findings.faulty(table + ".distribution")) {
    if (!findings.given(table + "." + needed))
      findings.report(table + "." + needed,
                      "the key is missing, but distribution = \"{}\" requires it; give {} = {}", name, needed,
                      is_weibull ? "20" : "0.1");
    if (findings.given(table + "." + useless))
      findings.report(table + "." + useless, "cannot be combined with distribution = \"{}\"; leave it out",
                      name);
  }
  const auto& strength = parameters.fracture.variation;
  const std::string key = table + ".with_strength";
  if (variation.with_strength == 0 || findings.faulty(key) || findings.faulty("fracture.variation")) return;
  if (!strength)
    findings.report(key, "requires [fracture.variation], with whose field this one is correlated");
  else if (strength->correlation_length != variation.correlation_length)
    findings.report(key, "requires the same correlation_length as in [fracture.variation] ({}); give it here",
                    strength->correlation_length > 0 ? show(strength->correlation_length) : "none");
}

/// Rejects a toughness if the corresponding strength is not known, and more than one toughness.
void check_toughness(const Parameters& parameters, std::size_t i, Findings& findings) {
  const std::string table = material_key(parameters.materials, i);
  if (findings.given(table + ".toughness") && findings.given(table + ".fracture_toughness"))
    findings.report(table + ".fracture_toughness",
                    "is given together with toughness; give only one of the two");
  check_release(table, findings);
  if (parameters.fracture.softens() || parameters.fracture_of(i).toughness == 0) return;
  constexpr double least = least_measured_poisson_ratio;
  constexpr double greatest = greatest_measured_poisson_ratio;
  const double nu = parameters.materials[i].poisson_ratio;
  if (findings.faulty(table + ".poisson_ratio") || (nu >= least && nu <= greatest)) return;
  findings.report(table + ".poisson_ratio",
                  "{} is out of range with fracture.toughness; give a ratio from {} to {}, or "
                  "fracture.strength instead of the toughness",
                  nu, least, greatest);
}

/// Either all materials have a strength or none has, and likewise a toughness.
void check_fracture_keys(const Parameters& parameters, Findings& findings) {
  if (findings.faulty("fracture") || findings.faulty("material")) return;
  const Fracture first = parameters.fracture_of(0);
  for (std::size_t i = 1; i < parameters.materials.size(); ++i) {
    const Fracture other = parameters.fracture_of(i);
    const auto check = [&](const char* key, double own, double of_first) {
      if ((own > 0) == (of_first > 0)) return;
      findings.report(fmt::format("material[{}]", i),
                      "\"{}\" has {} {}, but \"{}\" {}; give it for all materials or for none",
                      parameters.materials[i].name, own > 0 ? "a" : "no", key, parameters.materials[0].name,
                      own > 0 ? "has none" : "has one");
    };
    check("strength", other.strength, first.strength);
    check("toughness", other.toughness, first.toughness);
  }
}

void check_interfaces(const Parameters& parameters, Findings& findings) {
  const auto& materials = parameters.materials;
  std::set<std::set<std::string>> pairs;
  for (std::size_t i = 0; i < parameters.interfaces.size(); ++i) {
    const std::string table = fmt::format("interface[{}]", i);
    const std::string key = table + ".between";
    const Interface& interface = parameters.interfaces[i];
    if (findings.faulty(key) || !findings.given(key)) continue;
    const auto& [a, b] = interface.between;
    for (std::size_t k = 0; k < 2; ++k)
      check_is_named(materials, interface.between[k], fmt::format("{}[{}]", key, k), findings);
    if (a == b) findings.report(key, "names \"{}\" twice; give two materials", a);
    if (!pairs.insert({a, b}).second)
      findings.report(key, "the interface of \"{}\" and \"{}\" is given already", a, b);
    const Fracture fracture = parameters.fracture_of(0);
    if (interface.toughness > 0 && fracture.toughness == 0)
      findings.report(table + ".toughness", "the materials have a strength only; give a strength");
    if (interface.strength > 0 && fracture.strength == 0)
      findings.report(table + ".strength", "the materials have a toughness only; give a toughness");
    if (interface.strength == 0 && interface.toughness == 0)
      findings.report(table, "has neither strength nor toughness; give one, or leave the interface out");
  }
}

void check_region_materials(const Parameters& parameters, Findings& findings) {
  for (std::size_t i = 0; i < parameters.specimen.regions.size(); ++i) {
    const std::string key = fmt::format("specimen.region[{}].material", i);
    const std::string& name = parameters.specimen.regions[i].material;
    if (!findings.faulty(key) && findings.given(key))
      check_is_named(parameters.materials, name, key, findings);
  }
}

}  // namespace

std::string material_key(const std::vector<Material>& materials, std::size_t i) {
  return is_list(materials) || materials.size() > 1 ? fmt::format("material[{}]", i) : "material";
}

void check_is_named(const std::vector<Material>& materials, const std::string& name, const std::string& key,
                    Findings& findings) {
  if (material_named(materials, name) >= 0) return;
  findings.report(
      key, "there is no material \"{}\"; {}", name,
      is_list(materials) ? "give one of " + names_of(materials) : std::string("name it in [[material]]"));
}

void check_materials(const Parameters& parameters, Findings& findings) {
  constexpr std::size_t most = 255;  // they are numbered in a byte
  if (std::max(parameters.materials.size(), parameters.interfaces.size()) > most)
    findings.report("material", "there are more than {} materials or interfaces; give fewer", most);
  check_names(parameters.materials, findings);
  for (std::size_t i = 0; i < parameters.materials.size(); ++i) {
    if (parameters.materials[i].variation) check_stiffness_variation(parameters, i, findings);
    check_toughness(parameters, i, findings);
  }
  check_fracture_keys(parameters, findings);
  check_interfaces(parameters, findings);
  check_region_materials(parameters, findings);
}

}  // namespace crackle::input
