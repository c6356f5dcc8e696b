// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/dual_facets.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"
#include "input/model.h"

#include <filesystem>
#include <vector>

namespace crackle::io {

/// Writes a realization as a VTKHDF 1.0 unstructured grid: points in metres with the spacing required by the
/// input ("spacing", in metres) and the first mesh region that contains them ("region", -1 for none);
/// "displacement" (geometry::relative_displacements), where the mesh is perturbed; tetrahedra with the cell
/// fields "quality" (mean ratio), "refined" (geometry::refined_interior) and, if given, "strength_factor"
/// (fracture::strength_factors), "material" and "interface" (as in the realization, where these are not
/// empty); of a solid also points with "face", the number of its face's name. In addition /specimen as in
/// sample files, and /regions/box (r x 3 x 2), spacing (r): the part of the body covered by each mesh region.
/// Readable by ParaView and VTK 9.1. Written under a temporary name and renamed when complete, so an existing
/// file is replaced by a complete one or not at all. Not collective.
/// @throws std::runtime_error naming the file and what failed; nothing is left behind
void write_vtk_mesh(const std::filesystem::path& file, const geometry::Realization& realization,
                    const geometry::Body& body, const input::Mesh& mesh, const geometry::MotherPoints& base,
                    std::vector<double> strength_factor = {});

/// As write_vtk_mesh, for the dual facets: quadrilaterals with the cell field "tetrahedron".
void write_vtk_dual_surface(const std::filesystem::path& file, const geometry::DualSurface& surface);

}  // namespace crackle::io
