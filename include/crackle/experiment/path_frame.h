// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"
#include "crackle/experiment/experiments_file.h"

#include <optional>
#include <span>
#include <vector>

/// Crack paths as numbers: offsets from a common curve.
namespace crackle::experiment {

using plane::operator+, plane::operator-, plane::operator*;

/// Number of stations along a path.
inline constexpr std::size_t n_stations = 50;

double length_of(const Polyline& line);

/// Arc length of the point of the line that is nearest to `p`, and the distance to it.
struct Projection {
  double at;
  double distance;
};
Projection project(const Polyline& line, const plane::Point& p);

plane::Point point_at(const Polyline& line, double arc_length);

/// The line with its ends drawn out straight, each by this length.
Polyline extended(const Polyline& line, double length);

/// The line as read off with an error: shifted along its normals by a Gaussian process whose correlation
/// falls exponentially with the arc length.
Polyline with_reading_error(const Polyline& line, double deviation, double correlation_length,
                            RandomStream stream);

/// Stations on a curve amid all others, with normals.
struct PathFrame {
  Polyline curve;                    ///< the stations are on it; offsets are no larger than its length
  std::vector<plane::Point> place;   ///< of each station
  std::vector<plane::Point> normal;  ///< unit vectors; their mean is along +y or +z, whichever is nearer
  bool is_along_y = true;            ///< the mean normal is nearer to y than to z
};

/// The part of a crack that was in sight.
struct Window {
  plane::Point first, last;  ///< of the path as observed
  bool is_arrested = false;  ///< the crack ended at `last`, and more would have been seen
};

/// Stations on the medoid of the curves: that with the smallest mean distance to the others, among those of
/// nearly the usual length or more. The frame depends on the set of curves only, not on which of them are
/// experiments.
/// @param curves at least one, each of at least two points
/// @param windows the stations lie in what all of them show; those of paths that do not run along the medoid
/// do not count
/// @return empty if the windows leave nothing of the medoid
std::optional<PathFrame> path_frame(std::span<const Polyline> curves, std::span<const Window> windows);

/// True if what lies beside a path on the curve is at least half as long as the way between its ends, or as
/// the curve.
bool runs_along(const Polyline& curve, const plane::Point& first, const plane::Point& last);

/// Offset of a curve along the normal at each station [m]: to the nearest intersection; NaN where there is
/// none within the length of the frame's curve, and everywhere if the curve does not run along that of the
/// frame.
std::vector<double> offsets(const PathFrame& frame, const Polyline& curve);

}  // namespace crackle::experiment
