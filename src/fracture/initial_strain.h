// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/variation.h"
#include "input/material_model.h"
#include "mechanics/elasticity.h"
#include "mechanics/initial_strain.h"

#include <vector>

namespace crackle::fracture {

/// The input's initial stresses as strains of each tetrahedron, by their means over it: thermal
/// expansion, or the strain whose elastic stress is opposite to the given one. One part for each table of the
/// input. Equal for any number of ranks. Local.
/// @param elasticity of these tetrahedra
mechanics::InitialStrain make_initial_strain(const input::MaterialModel& model,
                                             const mechanics::ElasticityField& elasticity,
                                             const TetrahedronSpan& tetrahedra);

/// The same at a time of the load curves, for files.
std::vector<mechanics::Symmetric> initial_strain_at(const input::MaterialModel& model, double time,
                                                    const mechanics::ElasticityField& elasticity,
                                                    const TetrahedronSpan& tetrahedra);

}  // namespace crackle::fracture
