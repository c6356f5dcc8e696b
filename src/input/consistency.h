// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"
#include "findings.h"

/// Contradictions between keys. Each check skips what depends on a faulty key.
namespace crackle::input {

/// Sides and planes closer than this share of the body's size count as touching.
inline constexpr double touching = 1e-6;

/// True if two slots of a box overlap, or come as close as `near` [m] along each axis.
bool meet(const Region& slot, const Region& other, const Vector& near);

/// True if the extent of the body is valid.
bool size_is_known(const Findings& findings);

/// True if input::shape_of is defined. Call after complete_specimen and check_specimen.
bool shape_is_known(const Specimen& specimen, const Findings& findings);

/// Checks that the keys of the specimen are consistent, and derives the size of an outline and the shape of a
/// body other than a box. Call before the checks.
void complete_specimen(Parameters& parameters, Findings& findings);

/// Derives the toughness from a stress intensity, by Irwin's relation in plane strain. Call before the
/// checks.
void complete_fracture(Parameters& parameters, Findings& findings);

void check_specimen(const Parameters& parameters, Findings& findings);
void check_mesh(const Parameters& parameters, Findings& findings);
void check_sections(const Parameters& parameters, Findings& findings);
void check_fracture(const Parameters& parameters, Findings& findings);
void check_boundaries(const Parameters& parameters, Findings& findings);
void check_loads(const Parameters& parameters, Findings& findings);
void check_time(const Parameters& parameters, Findings& findings);
void check_output(const Parameters& parameters, Findings& findings);
void check_random(const Parameters& parameters, Findings& findings);
void check_sweeps(const Parameters& parameters, Findings& findings);

/// The kinds given by a [[boundary]] in the file; there should be one.
std::vector<std::string> kinds_given(const Findings& findings, const std::string& table);

}  // namespace crackle::input
