// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/breakable_body.h"
#include "fracture/variation.h"
#include "input/material_model.h"
#include "mechanics/elasticity.h"
#include "parallel/communicator.h"

#include <cstdint>

namespace crackle::fracture {

/// Stiffness and density of each tetrahedron: those of its material, times the sample's variation.
/// Equal for any number of ranks. Local.
mechanics::MaterialField make_material_field(const input::MaterialModel& model, std::uint64_t sample,
                                             const TetrahedronSpan& tetrahedra);

/// Speeds of waves in the slowest of a body's materials, each the mean over its volume of what one wave takes
/// to cross it: with rasters and variations [m/s].
struct BodyWaves {
  double bar;           ///< longitudinal, in a thin bar
  double dilatational;  ///< plane, in an unbounded body
};

/// Collective; equal for any number of ranks.
BodyWaves slowest_waves(const parallel::Communicator& group, const input::MaterialModel& model,
                        const BreakableBody& body);

}  // namespace crackle::fracture
