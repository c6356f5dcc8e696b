// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/stand_in.h"

#include "common/stopwatch.h"
#include "ensemble/base_points.h"
#include "ensemble/memory.h"
#include "ensemble/scaling.h"
#include "geometry/mother_points.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

namespace crackle::ensemble {

namespace {

/// Large enough not to fit a core's own cache, as the mesh that is meant.
constexpr double wanted_nodes = 1e5;
/// More are not tried after a mesh has failed: they take minutes.
constexpr double most_nodes = 1e6;
constexpr double least_refinement = 1.5, most_refinement = 30;
/// A larger factor of spacings is of use if it lowers the number of nodes to this share.
constexpr double useful_share = 0.9;

input::Parameters coarsened(input::Parameters parameters, double factor) {
  input::Mesh& mesh = parameters.mesh;
  for (double* const value : {&mesh.spacing, &mesh.notch_spacing, &mesh.growth}) *value *= factor;
  for (input::MeshRegion& region : mesh.regions) region.spacing *= factor;
  return parameters;
}

/// The factor of spacings that leaves about so many nodes, or as few as it can: features of the body keep
/// their own spacings.
double refinement_over(const input::Parameters& parameters, const geometry::Body& body, double n_nodes,
                       double wanted) {
  double factor = 1;
  for (int round = 0; round < 5; ++round) {
    if (n_nodes < 1.2 * wanted) break;
    const double larger = std::min(most_refinement, factor * std::cbrt(n_nodes / wanted));
    const double fewer = geometry::estimate_n_points(body, coarsened(parameters, larger).mesh);
    if (fewer > useful_share * n_nodes) break;
    factor = larger;
    n_nodes = fewer;
  }
  return factor;
}

StandIn made(const input::Parameters& parameters, const geometry::Body& body, double n_nodes,
             double refinement) {
  StandIn result{coarsened(parameters, refinement), refinement};
  const auto finest = [&](const input::Mesh& mesh) {
    return geometry::SpacingField(body, mesh).lower_bound(body.bounds());
  };
  result.finest_ratio = finest(result.parameters.mesh) / finest(parameters.mesh);
  const ThreadClock clock;
  const auto shared = parameters.mesh.base == input::Base::shared
                          ? make_base_points(body, result.parameters.mesh, result.parameters.seed)
                          : geometry::MotherPoints{};
  const double of_base = clock.seconds();
  result.realization = make_sample_realization(body, shared, result.parameters, 0);
  result.mesh_seconds = clock.seconds() - of_base;
  const auto nodes = static_cast<double>(result.realization.nodes.size());
  const auto triangles = static_cast<double>(result.realization.boundary.size());
  // Both numbers of nodes are estimated alike, so that errors cancel.
  const double growth = n_nodes / geometry::estimate_n_points(body, result.parameters.mesh);
  result.n_nodes = growth * nodes;
  const double growth_of_surfaces = std::pow(growth, 2.0 / 3);
  result.n_tetrahedra =
      expected_tetrahedra(result.n_nodes, growth_of_surfaces * triangles) *
      (static_cast<double>(result.realization.tetrahedra.size()) / expected_tetrahedra(nodes, triangles));
  return result;
}

}  // namespace

StandIn make_stand_in(const input::Parameters& parameters, const geometry::Body& body, double n_nodes) {
  double refinement = refinement_over(parameters, body, n_nodes, wanted_nodes);
  std::optional<std::runtime_error> reason;
  // Spacings may be too large for details of the body.
  for (;; refinement = std::sqrt(refinement)) {
    const auto coarse = coarsened(parameters, refinement);
    if (reason && geometry::estimate_n_points(body, coarse.mesh) > most_nodes) throw *reason;
    if (const auto message =
            shortage(expected_mesh_memory(coarse, body), "making a coarser mesh", available_memory()))
      throw reason
          ? *reason
          : std::runtime_error(*message + "; use coarser spacings, or check the input on a larger machine");
    try {
      return made(parameters, body, n_nodes, refinement);
    } catch (const std::runtime_error& error) {
      if (refinement < least_refinement) throw;
      reason = error;
    }
  }
}

}  // namespace crackle::ensemble
