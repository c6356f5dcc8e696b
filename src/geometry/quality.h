// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/point.h"

#include <array>

namespace crackle::geometry {

/// Signed volume [m^3]; positive for the orientation of tetrahedra in a realization.
double signed_volume(const Point& a, const Point& b, const Point& c, const Point& d);

/// Mean-ratio quality 12 (3V)^(2/3) / sum of squared edge lengths; 1 for the regular tetrahedron, 0 for a
/// flat or inverted one.
double mean_ratio(const Point& a, const Point& b, const Point& c, const Point& d);

/// The third power of the mean-ratio quality, by rational operations only, so that comparisons are equal on
/// every machine. Ignores the orientation.
double mean_ratio_cubed(const Point& a, const Point& b, const Point& c, const Point& d);

/// The six angles between neighbouring faces, inside the tetrahedron [rad].
std::array<double, 6> dihedral_angles(const Point& a, const Point& b, const Point& c, const Point& d);

}  // namespace crackle::geometry
