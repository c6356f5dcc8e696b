// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/random.h"
#include "geometry/body.h"

#include "tessellation.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace crackle::geometry {

/// A random point, uniform within `radius` of `centre` at its place: in a ball, a disc or a segment.
/// Positions at another place are redrawn.
Point displaced(const Body& body, const Point& centre, PlaceId place, double radius, RandomStream stream);

/// Another position for a point.
/// @param draw 1 for the first redraw of this point, 2 for the second, ...
/// @param amplitude factor for the point's full amplitude, from 1 down to 0
using Draw = std::function<Point(std::int32_t node, std::int32_t draw, double amplitude)>;

struct RedrawRules {
  int max_rounds = 0;
  /// Gives up after this many rounds without a 10 % reduction of bad cells; after a tenth of that if there
  /// are many.
  int patience = std::numeric_limits<int>::max();
  /// True: a point only moves if that improves the cells around it. False: a redrawn point takes the best of
  /// the new positions.
  bool only_improve = false;
  /// The amplitude of a point shrinks with repeated redrawing. Unless points only move to improve, growing
  /// neighbourhoods of persistent bad cells are finally set to amplitude 0: redrawing thus succeeds whenever
  /// the points at amplitude 0 have good cells only.
  bool shrinking = true;
};

struct RedrawOutcome {
  int rounds = 0;
  std::int64_t redrawn_points = 0;
  std::vector<Tetrahedron> remaining;  ///< bad cells left; empty on success
};

/// Redraws points of bad cells, one at a time, until every cell is good or the maximum number of rounds is
/// reached.
///
/// A round visits the bad cells in ascending order. One point of each is lifted and placed where, among
/// several draws, the fewest bad cells and then the best minimum quality result; only the affected cells are
/// examined. If a cell remains bad, its other points and then their neighbours are redrawn.
/// @param choice decides between equally suitable points
RedrawOutcome redraw(Tessellation& tessellation, std::span<const std::uint8_t> movable, const Draw& draw,
                     RandomStream choice, const RedrawRules& rules);

}  // namespace crackle::geometry
