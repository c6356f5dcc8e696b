// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/dual_facets.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <filesystem>
#include <vector>

namespace crackle::io {

/// Writes a realization as a VTKHDF 1.0 unstructured grid: points in metres with the spacing that the input
/// asks for there ("spacing", in metres) and the first region of the mesh that holds them ("region", -1 for
/// none), tetrahedra with the cell fields "quality" (mean ratio) and, where it is given, "strength_factor"
/// (fracture::strength_factors). Beside the grid, /specimen as in sample
/// files, and /regions/box (r x 3 x 2), spacing (r): the part of the body that each region of the mesh
/// covers. Readable by ParaView and VTK 9.1. Written under another name and renamed when whole, so an
/// existing file is replaced by a whole one or not at all. Not collective.
/// @throws std::runtime_error naming the file and what failed; nothing is left behind
void write_vtk_mesh(const std::filesystem::path& file, const geometry::Realization& realization,
                    const geometry::Body& body, const input::Mesh& mesh,
                    std::vector<double> strength_factor = {});

/// As write_vtk_mesh, for the dual facets: quadrilaterals with the cell field "tetrahedron".
void write_vtk_dual_surface(const std::filesystem::path& file, const geometry::DualSurface& surface);

}  // namespace crackle::io
