// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/realization.h"
#include "input/parameters.h"

namespace crackle::ensemble {

/// A coarser mesh of the same body, for estimates of one that is too large to be made for them.
struct StandIn {
  input::Parameters parameters;  ///< the input with all spacings multiplied
  double refinement = 1;         ///< by this number
  double finest_ratio = 1;       ///< of the smallest spacings, which features of the body may set
  geometry::Realization realization = {};
  double mesh_seconds = 0;  ///< to make this realization, on one core
  double n_nodes = 0;       ///< expected of the input's own mesh
  double n_tetrahedra = 0;
};

/// Sample 0 on some 100,000 nodes, or more where features of the body need them. Not collective.
/// @param n_nodes of the input's own mesh, from geometry::checked_n_points
/// @throws std::runtime_error with the reason if no such mesh can be made, or memory is short
StandIn make_stand_in(const input::Parameters& parameters, const geometry::Body& body, double n_nodes);

}  // namespace crackle::ensemble
