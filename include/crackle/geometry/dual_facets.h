// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/realization.h"

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

namespace crackle::geometry {

/// The node pairs of a tetrahedron's six dual facets, in their order.
inline constexpr std::array<std::array<std::size_t, 2>, 6> dual_facet_nodes{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// Vector areas of the six dual facets of a tetrahedron, from the first to the second node of its pair: S^ab
/// = V (grad N_b - grad N_a) / 4 [m^2].
std::array<Point, 6> dual_facet_areas(const Point& a, const Point& b, const Point& c, const Point& d);

/// Orientation of the candidate crack facets: the moments of the normals n of the dual facets, weighted by
/// area.
struct OrientationMoments {
  double area = 0;                                                              ///< [m^2]
  std::array<std::array<double, 3>, 3> second{};                                ///< mean of n_i n_j
  std::array<std::array<std::array<std::array<double, 3>, 3>, 3>, 3> fourth{};  ///< mean of n_i n_j n_k n_l
};

/// Adds `share` times the other moments, for means over realizations.
void add_share(OrientationMoments& moments, const OrientationMoments& other, double share);

/// Over the tetrahedra with centroid in the region.
OrientationMoments orientation_moments(const Realization& realization,
                                       const std::function<bool(const Point& centroid)>& region);

/// Distance of the second moment from the isotropic one, delta_ij / 3, relative to the latter (Frobenius
/// norms): 0 for no preferred direction, 1.41 if all normals are parallel.
double second_order_bias(const OrientationMoments& moments);

/// As second_order_bias for the fourth moment, whose isotropic value is (delta_ij delta_kl + delta_ik
/// delta_jl + delta_il delta_jk) / 15. It detects the planes of a cubic lattice, which are isotropic to
/// second order.
double fourth_order_bias(const OrientationMoments& moments);

/// All dual facets as quadrilaterals: edge midpoint, face centroid, tetrahedron centroid, face centroid.
struct DualSurface {
  std::vector<Point> points;  ///< [m]
  std::vector<std::array<std::int32_t, 4>> quadrilaterals;
  std::vector<std::int32_t> tetrahedron;  ///< of each quadrilateral
};

DualSurface dual_surface(const Realization& realization);

}  // namespace crackle::geometry
