// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "findings.h"
#include "input/parameters.h"

#include <optional>
#include <string>
#include <vector>

/// Contradictions between keys. Each check skips what depends on a faulty key.
namespace crackle::input {

struct Wall;

/// Sides and planes closer than this share of the body's size count as touching.
inline constexpr double touching = 1e-6;

/// True if the extent of the body is valid.
bool size_is_known(const Findings& findings);

/// True if plane::shape_of is defined, or there is a solid. Call after complete_specimen and check_specimen.
bool shape_is_known(const plane::Specimen& specimen, const Findings& findings);

/// Checks that the keys of the specimen are consistent, and derives the size of an outline and the shape of a
/// body other than a box. Call before the checks.
void complete_specimen(Parameters& parameters, Findings& findings);

/// Checks the pre-cracks and flaws.
void check_cracks(const Parameters& parameters, Findings& findings);

/// Checks the keys of regions and derives their outlines. Part of complete_specimen.
void make_region_outlines(Parameters& parameters, Findings& findings);

/// Checks the regions against each other and the body, and adapts their outlines. Call after check_specimen.
void complete_regions(Parameters& parameters, Findings& findings);

/// Derives the toughness from a stress intensity, by Irwin's relation in plane strain. Call before the
/// checks.
void complete_fracture(Parameters& parameters, Findings& findings);

/// Reports a table that gives both release_time and release_speed.
void check_release(const std::string& table, Findings& findings);

void check_specimen(const Parameters& parameters, Findings& findings);
void check_materials(const Parameters& parameters, Findings& findings);
void check_mesh(const Parameters& parameters, Findings& findings);
void check_stop(const Parameters& parameters, Findings& findings);
void check_sections(const Parameters& parameters, Findings& findings);
/// Warnings about sections outside the ligaments of all notches of a body with holes, whose cracks may reach
/// them: one sentence each.
std::vector<std::string> section_warnings(const Study& study);
void check_fracture(const Parameters& parameters, Findings& findings);
void check_boundaries(const Parameters& parameters, Findings& findings);
/// Reports a load that acts only where motions are prescribed in its direction.
/// @param walls of the body
void check_idle_load(const Model& model, std::size_t i, const std::vector<Wall>& walls, Findings& findings);
/// Warnings about loads that act in part where a motion is prescribed in their direction: one sentence each.
std::vector<std::string> idle_load_warnings(const Model& model);
void check_initial_stresses(const Parameters& parameters, Findings& findings);
void check_loads(const Parameters& parameters, Findings& findings);
void check_tools(const Parameters& parameters, Findings& findings);
/// Checks [contact] and fracture.contact.
void check_contact(const Parameters& parameters, Findings& findings);
void check_time(const Parameters& parameters, Findings& findings);
void check_output(const Parameters& parameters, Findings& findings);
void check_random(const Parameters& parameters, Findings& findings);
void check_sweeps(const Parameters& parameters, Findings& findings);

/// "random[0].lower", a parameter of the distribution of a random key, if the key's own value has no effect
/// on that; otherwise empty.
std::optional<std::string> parameter_instead_of(const std::string& key, const Parameters& parameters);

/// Key of a material's table: "material", or "material[1]" of several.
std::string material_key(const std::vector<Material>& materials, std::size_t i);

/// Reports a name that no [[material]] has.
void check_is_named(const std::vector<Material>& materials, const std::string& name, const std::string& key,
                    Findings& findings);

/// Key of the map's table: that of the last material.
std::string map_key(const Parameters& parameters);

/// Checks [material.map], and computes the checksum if it is not given. Call before the checks.
void complete_map(Parameters& parameters, Findings& findings);

}  // namespace crackle::input
