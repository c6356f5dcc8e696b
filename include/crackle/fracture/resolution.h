// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/toughness.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <string>
#include <vector>

namespace crackle::fracture {

/// The spacings where cracks run: along the ligaments, or anywhere in a body without notches [m].
Range crack_spacing(const input::Parameters& parameters, const geometry::Body& body);

/// Warnings where the input's mesh does not resolve its fracture model: a toughness that varies with the
/// spacing, an averaging ball, process zone or correlation length of too few spacings.
/// @param time_step of the dynamic phases [s]
std::vector<std::string> resolution_warnings(const input::Parameters& parameters, const geometry::Body& body,
                                             double time_step);

}  // namespace crackle::fracture
