// SPDX-License-Identifier: GPL-3.0-or-later
// [contact]: surfaces that meet.
#include "consistency.h"
#include "schema.h"

namespace crackle::input {

Table contact_table() {
  return {
      "contact",
      Occurrence::optional,
      "contact of cracks that close and, in dynamic phases only, of surfaces that meet, such as sides of "
      "cracks farther apart than a spacing",
      {number_key(
           "friction",
           [](Parameters& parameters, std::size_t) -> double& { return parameters.contact->friction; },
           {0, 10}, optional("required, or fracture.contact = \"frictionless\""), "Coulomb's coefficient"),
       number_key(
           "stiffness",
           [](Parameters& parameters, std::size_t) -> double& { return parameters.contact->stiffness; },
           {0.001, 10}, by_default("0.2"),
           "of surfaces that meet: raises the largest squared frequency by this share, and shortens the "
           "stable "
           "step accordingly")},
      [](const Parameters& parameters) { return parameters.contact ? std::size_t{1} : 0; },
      [](Parameters& parameters) { parameters.contact.emplace(); }};
}

void check_contact(const Parameters& parameters, Findings& findings) {
  const bool is_frictionless = parameters.fracture.contact == Contact::frictionless;
  if (parameters.contact && !is_frictionless && !findings.given("contact.friction"))
    findings.report("contact.friction", "the key is missing; give a number such as 0.3");
  if (parameters.contact && findings.given("fracture.contact") && findings.given("contact.friction") &&
      (!is_frictionless || parameters.contact->friction != 0))
    findings.report("contact.friction", "contradicts fracture.contact = \"{}\"; leave one of the two out",
                    is_frictionless ? "frictionless" : "none");
  if (parameters.time.engine == Engine::petsc && parameters.surface_contact())
    findings.report(parameters.contact ? "contact.friction" : "fracture.contact",
                    "contact is nonlinear and not available with time.engine = \"petsc\"; leave it out, or "
                    "give time.engine = \"fixed-point\"");
}

}  // namespace crackle::input
