// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "input/model.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The symmetries of the body that also map the mesh regions onto regions of the same spacing, to 1e-12 of
/// the body's largest size.
std::vector<Symmetry> symmetries(const Body& body, const input::Mesh& mesh);

/// The symmetries of the body that its boundary conditions share: each maps the place, direction and size of
/// what acts onto those of something that acts. Equilibria do not know a support from the load that it
/// balances, nor a rigid motion: unless the body starts from rest, a support that alone carries a central
/// load may change places with it, prescribed motions may differ by a common translation, and a component in
/// which nothing is driven may be held on one of two loaded faces only. The identity is always among them,
/// and the only one with tools.
///
/// Factors, body forces and the initial velocity must be mapped onto themselves, and with them no support
/// changes places with a load.
std::vector<Symmetry> loaded_symmetries(const Body& body, const input::Model& model);

/// The body's symmetry with this code.
/// @throws std::invalid_argument when there is none
Symmetry symmetry_of(const Body& body, std::uint8_t code);

}  // namespace crackle::geometry
