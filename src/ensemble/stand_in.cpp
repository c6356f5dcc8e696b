// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/stand_in.h"

#include "common/stopwatch.h"
#include "ensemble/base_points.h"
#include "ensemble/scaling.h"
#include "geometry/mother_points.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace crackle::ensemble {

namespace {

/// Large enough not to fit a core's own cache, as the mesh that is meant.
constexpr double wanted_nodes = 1e5;
constexpr double least_refinement = 1.5;

input::Parameters coarsened(input::Parameters parameters, double factor) {
  input::Mesh& mesh = parameters.mesh;
  for (double* const value : {&mesh.spacing, &mesh.notch_spacing, &mesh.growth}) *value *= factor;
  for (input::MeshRegion& region : mesh.regions) region.spacing *= factor;
  return parameters;
}

/// The factor of spacings that leaves about so many nodes. Features of the body keep their own.
double refinement_over(const input::Parameters& parameters, double n_nodes, double wanted) {
  double factor = 1;
  for (int round = 0; round < 5; ++round) {
    if (n_nodes < 1.2 * wanted) break;
    factor *= std::cbrt(n_nodes / wanted);
    const auto coarse = coarsened(parameters, factor);
    n_nodes = geometry::estimate_n_points(*geometry::make_body(coarse), coarse.mesh);
  }
  return factor;
}

StandIn made(const input::Parameters& parameters, double n_nodes, double refinement) {
  StandIn result{coarsened(parameters, refinement), refinement};
  const auto body = geometry::make_body(result.parameters);
  const auto finest = [&](const input::Mesh& mesh) {
    return geometry::SpacingField(*body, mesh).lower_bound(body->bounds());
  };
  result.finest_ratio = finest(result.parameters.mesh) / finest(parameters.mesh);
  const ThreadClock clock;
  const auto shared = parameters.mesh.base == input::Base::shared
                          ? make_base_points(*body, result.parameters.mesh, result.parameters.seed)
                          : geometry::MotherPoints{};
  const double of_base = clock.seconds();
  result.realization = make_sample_realization(*body, shared, result.parameters, 0);
  result.mesh_seconds = clock.seconds() - of_base;
  const auto nodes = static_cast<double>(result.realization.nodes.size());
  const auto triangles = static_cast<double>(result.realization.boundary.size());
  // Both numbers of nodes are estimated alike, so that errors cancel.
  const double growth = n_nodes / geometry::estimate_n_points(*body, result.parameters.mesh);
  result.n_nodes = growth * nodes;
  const double growth_of_surfaces = std::pow(growth, 2.0 / 3);
  result.n_tetrahedra =
      expected_tetrahedra(result.n_nodes, growth_of_surfaces * triangles) *
      (static_cast<double>(result.realization.tetrahedra.size()) / expected_tetrahedra(nodes, triangles));
  return result;
}

}  // namespace

StandIn make_stand_in(const input::Parameters& parameters, double n_nodes) {
  double refinement = refinement_over(parameters, n_nodes, wanted_nodes);
  // Spacings may be too large for details of the body.
  for (;; refinement = std::sqrt(refinement)) {
    try {
      return made(parameters, n_nodes, refinement);
    } catch (const std::runtime_error&) {
      if (refinement < least_refinement) throw;
    }
  }
}

}  // namespace crackle::ensemble
