// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crossings.h"

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace crackle::cracks {

struct Branch {
  Indices facets;
  Indices first;                                ///< the subset on the first min_branch_length
  std::vector<std::pair<double, double>> line;  ///< advance, across: centre at every station
  double reach = 0;                             ///< advance of its end [m]
  double end_across = 0;                        ///< coordinate across at its end [m]
  double length = 0;                            ///< straight length from the branching point to its end [m]
};

/// A branching point detected in one window; branches 0 and 1 are at lower and higher values across.
struct Detection {
  double advance;  ///< where the branches separate
  double across;
  double angle;
  std::array<Branch, 2> branches;
  int window = 0;        ///< window of the detection
  std::size_t last = 0;  ///< station of the last levels
  Indices reunited;      ///< the runs there, if the branches have met again
};

/// Extends branches that have met with those of a later detection.
void extend(Detection& point, const Detection& later);

/// Detects branching points of the part of a crack between two planes x = const, projected on the plane of
/// the plate.
/// @param step distance between stations [m]
/// @param spacing local mesh spacing at every station [m]
/// @param traces of the crack at every station
std::vector<Detection> detect_branching(double step, const std::vector<double>& spacing,
                                        const std::vector<std::vector<Trace>>& traces, double x_low,
                                        double x_high);

}  // namespace crackle::cracks
