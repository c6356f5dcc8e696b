// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "findings.h"
#include "input/parameters.h"

#include <string>

namespace crackle::input {

/// Checks the keys of a solid against others, and derives its size. Part of complete_specimen.
void complete_solid(Parameters& parameters, Findings& findings);

/// Checks its corners and edges against the mesh. @pre parameters.specimen.solid or a finding
void check_solid(const Parameters& parameters, Findings& findings);

/// Checks that a condition's face is there, and that its region meets it.
void check_region_of_solid(const Boundary& condition, const std::string& key, const solid::Solid& body,
                           Findings& findings);

/// The share of a load's area that is also a motion's; of a line the share of its length.
double share_driven(const Boundary& load, const Boundary& motion, const solid::Solid& body);

/// True if two conditions act on a common part of the surface, more than a border.
bool have_common_part(const Boundary& a, const Boundary& b, const solid::Solid& body);

}  // namespace crackle::input
