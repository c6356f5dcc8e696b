// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/dual_facets.h"
#include "crackle/geometry/realization.h"

#include <filesystem>

namespace crackle::io {

/// Writes a realization as a VTKHDF 1.0 unstructured grid: points in metres, tetrahedra with the cell field
/// "quality" (mean ratio). Readable by ParaView and VTK 9.1. Written under another name and renamed when
/// whole, so an existing file is replaced by a whole one or not at all. Not collective.
/// @throws std::runtime_error naming the file and what failed; nothing is left behind
void write_vtk_mesh(const std::filesystem::path& file, const geometry::Realization& realization);

/// As write_vtk_mesh, for the dual facets: quadrilaterals with the cell field "tetrahedron".
void write_vtk_dual_surface(const std::filesystem::path& file, const geometry::DualSurface& surface);

}  // namespace crackle::io
