// SPDX-License-Identifier: GPL-3.0-or-later
// [material], or [[material]], with its variation, and [[interface]].
#include "schema.h"

#include <array>

namespace crackle::input {

namespace {

template <class T>
Access<T> material(T Material::*member) {
  return [=](Parameters& parameters, std::size_t i) -> T& { return parameters.materials.at(i).*member; };
}

Table material_table() {
  const Requirement as_fracture = optional("as in [fracture]");
  return {"material",
          Occurrence::once_or_many,
          "isotropic linear elasticity, and its own values of keys of [fracture]",
          {name_key(material(&Material::name), optional("required with [[material]]"), "glass",
                    "of one of several materials")
               .that_affects(Affects::materials),
           quantity_key("youngs_modulus", material(&Material::youngs_modulus),
                        with_example(stress_dimension, "3300 MPa"), positive_stress, required(),
                        "Young's modulus")
               .also_called({"E", "young", "youngs", "elastic_modulus", "modulus_of_elasticity"}),
           number_key("poisson_ratio", material(&Material::poisson_ratio), {-1, 0.5, true, true}, required(),
                      "Poisson's ratio")
               .also_called({"nu", "v", "poisson", "poissons_ratio"}),
           quantity_key("density", material(&Material::density), density_dimension, {0, 1e6, true},
                        required(), "mass density")
               .also_called({"rho", "mass_density"}),
           optional_quantity_key("strength", material(&Material::strength), stress_dimension, positive_stress,
                                 as_fracture, "in place of that of [fracture]")
               .also_called({"sigma_0", "sigma_c", "sigma_t", "f_t", "tensile_strength"}),
           toughness_key(material(&Material::toughness), as_fracture, "in place of that of [fracture]")
               .also_called({"G_c", "G_Ic", "G_f", "G", "fracture_energy", "energy_release_rate"}),
           optional_quantity_key("fracture_toughness", material(&Material::fracture_toughness),
                                 stress_intensity_dimension, {0, 1e12, true}, as_fracture,
                                 "K_Ic, in place of that of [fracture]")
               .also_called({"K_Ic", "K_c", "K_1c", "KI", "K"}),
           hidden_at_zero(
               impulse_key(material(&Material::impulse), as_fracture, "in place of that of [fracture]"),
               material(&Material::impulse)),
           release_time_key(material(&Material::release_time), as_fracture,
                            "in place of release_time and release_speed of [fracture]"),
           release_speed_key(material(&Material::release_speed), as_fracture,
                             "in place of release_time and release_speed of [fracture]")},
          [](const Parameters& parameters) { return parameters.materials.size(); },
          [](Parameters& parameters) { parameters.materials.emplace_back(); }};
}

/// The key, hidden for materials that do not vary.
Key of_variation(Key key) {
  key.read = [read = key.read](const Source& source, Parameters& parameters, std::size_t i) {
    auto& variation = parameters.materials.at(i).variation;
    if (!variation) variation.emplace();
    read(source, parameters, i);
  };
  return shown_if(std::move(key), [](const Parameters& parameters, std::size_t i) {
    return parameters.materials.at(i).variation.has_value();
  });
}

Table stiffness_variation_table() {
  const auto variation = [](auto StiffnessVariation::*member) {
    return [=](Parameters & parameters, std::size_t i) -> auto& {
      return parameters.materials.at(i).variation.value().*member;
    };
  };
  std::vector<Key> keys{
      choice_key<StiffnessVaries>("of", variation(&StiffnessVariation::of),
                                  {{"stiffness", StiffnessVaries::stiffness},
                                   {"density", StiffnessVaries::density},
                                   {"both", StiffnessVaries::both}},
                                  by_default("\"stiffness\""),
                                  "multiplied by the factor; stiffness is Young's modulus"),
      choice_key<Distribution>("distribution", variation(&StiffnessVariation::distribution),
                               {{"weibull", Distribution::weibull}, {"lognormal", Distribution::lognormal}},
                               required(), "of the factor: Weibull with scale 1, lognormal with mean 1"),
      optional_number_key("modulus", variation(&StiffnessVariation::modulus), {1, 1000},
                          "required for \"weibull\"", "Weibull modulus (shape)")
          .also_called({"m", "weibull_modulus", "shape"}),
      optional_number_key("coefficient_of_variation",
                          variation(&StiffnessVariation::coefficient_of_variation), {0, 2, true},
                          "required for \"lognormal\"", "of the lognormal distribution")
          .also_called({"cov", "cv"}),
      optional_quantity_key("correlation_length", variation(&StiffnessVariation::correlation_length),
                            with_example(length_dimension, "2 mm"), positive_length,
                            optional("a factor for each tetrahedron"), "of the underlying Gaussian field")
          .also_called({"xi"}),
      number_key("with_strength", variation(&StiffnessVariation::with_strength), {-1, 1}, by_default("0"),
                 "correlation with the field of [fracture.variation], whose correlation length it then has")};
  for (Key& key : keys) key = of_variation(std::move(key));
  return {"material.variation",
          Occurrence::optional,
          "random stiffness or density in space, of the [material] or [[material]] above it",
          std::move(keys),
          [](const Parameters& parameters) { return parameters.materials.size(); },
          {},
          "material"};
}

Key between_key() {
  const std::string form = "the names of two materials, such as [\"glass\", \"epoxy\"]";
  return pair_key(
      [](Parameters & parameters, std::size_t i) -> auto& { return parameters.interfaces.at(i).between; },
      form, "the name of a material", "the materials that meet");
}

Table interface_table() {
  const auto interface = [](double Interface::*member) -> Access<double> {
    return
        [=](Parameters& parameters, std::size_t i) -> double& { return parameters.interfaces.at(i).*member; };
  };
  const Requirement own = optional("that of the material");
  return {"interface",
          Occurrence::many,
          "where two materials meet: the tetrahedra with a node on their boundary",
          {between_key().that_affects(Affects::materials),
           optional_quantity_key("strength", interface(&Interface::strength), stress_dimension,
                                 positive_stress, own, "of these tetrahedra"),
           toughness_key(interface(&Interface::toughness), own, "of these tetrahedra")
               .also_called({"G_c", "G_Ic", "G_f", "fracture_energy"})},
          [](const Parameters& parameters) { return parameters.interfaces.size(); },
          [](Parameters& parameters) { parameters.interfaces.emplace_back(); }};
}

}  // namespace

std::vector<Table> material_tables() {
  return {material_table(), stiffness_variation_table(), map_table(), interface_table()};
}

}  // namespace crackle::input
