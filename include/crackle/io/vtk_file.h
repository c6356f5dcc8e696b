// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/realization.h"

#include <filesystem>

namespace crackle::io {

/// Writes a realization as a VTKHDF 1.0 unstructured grid (tetrahedra with their mean-ratio quality),
/// readable by ParaView and VTK 9.1. Written under another name and renamed when whole.
void write_vtk_mesh(const std::filesystem::path& file, const geometry::Realization& realization);

}  // namespace crackle::io
