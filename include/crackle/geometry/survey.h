// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/dual_facets.h"
#include "crackle/geometry/mesh_statistics.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>

namespace crackle::geometry {

/// The interior of the finely meshed zone, where cracks start and orientations are measured: the spacing is
/// at most twice the notch spacing, and the surface at least two spacings away.
class FineZone {
public:
  FineZone(const Body& body, const input::Mesh& mesh);
  bool contains(const Point& p) const;

private:
  const Body& body_;
  SpacingField spacing_;
  double largest_spacing_;
};

/// Sums over the displacements of points of one kind, in units of the amplitude perturbation x spacing; only
/// movable coordinates count.
struct DisplacementSums {
  std::array<double, 3> n{};    ///< displacements along each axis
  std::array<double, 3> sum{};  ///< of the coordinates
  std::array<std::array<double, 3>, 3> n_products{};
  std::array<std::array<double, 3>, 3> products{};  ///< sum of the products of two coordinates

  void add(const DisplacementSums& other);
  double mean(std::size_t i) const { return sum[i] / n[i]; }
  double covariance(std::size_t i, std::size_t j) const { return products[i][j] / n_products[i][j]; }
};

/// The figures of one realization. Equal on every machine, except the times.
struct SurveyRow {
  std::uint64_t sample = 0;
  std::string error;  ///< why there is no conforming realization; the other members are then empty
  std::int64_t n_nodes = 0;
  std::int64_t n_tetrahedra = 0;
  RealizationReport report;
  MeshStatistics mesh;
  OrientationMoments orientation;  ///< of the candidate facets in the fine zone
  /// By number of movable coordinates: along edges (0), in faces (1), in the interior (2).
  std::array<DisplacementSums, 3> displacement;
  double seconds = 0;           ///< one-core time to make and check the realization
  double delaunay_seconds = 0;  ///< one-core time of a plain CGAL tessellation of the same points
};

/// Measures realizations one by one.
class Survey {
public:
  /// The references must outlive the survey.
  /// @param base of all samples; with mesh.base = "own" that of sample 0, the others make their own
  Survey(const Body& body, const MotherPoints& base, const input::Mesh& mesh, std::uint64_t seed);
  /// @param inspect called with the realization, if it conforms
  SurveyRow measure(std::uint64_t sample, const std::function<void(const Realization&)>& inspect = {}) const;
  /// The orientation of the candidate facets in the unperturbed base mesh.
  OrientationMoments base_orientation() const;

private:
  const Body& body_;
  const MotherPoints& base_;
  const input::Mesh& mesh_;
  std::uint64_t seed_;
  FineZone zone_;
};

}  // namespace crackle::geometry
