// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/toughness.h"
#include "geometry/body.h"
#include "input/model.h"

#include <optional>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// The spacings where cracks run: along the ligaments, or anywhere in a body without notches [m].
fracture::Range crack_spacing(const input::Mesh& mesh, const geometry::Body& body);

/// The toughness corresponding to a strength [Pa] at the spacings along the ligaments [J/m^2]; empty without
/// notches.
std::optional<fracture::Range> toughness_along_ligaments(const input::Model& model,
                                                         const geometry::Body& body, double strength);

/// Warnings where the input's mesh does not resolve its fracture model: a toughness that varies with the
/// spacing, an averaging ball, process zone or correlation length of too few spacings.
/// @param time_step of the dynamic phases [s]
std::vector<std::string> resolution_warnings(const input::Model& model, const geometry::Body& body,
                                             double time_step);

}  // namespace crackle::dynamics
