// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"

#include "tessellation.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace crackle::geometry {

/// Another position for a point.
/// @param draw 1 for the first redraw of this point, 2 for the second, ...
/// @param amplitude factor for the point's full amplitude, from 1 down to 0
using Draw = std::function<Point(std::int32_t node, std::int32_t draw, double amplitude)>;

struct RedrawRules {
  int max_rounds = 0;
  /// Gives up after this many rounds without a tenth less bad cells; a tenth of that when there are many.
  int patience = std::numeric_limits<int>::max();
  /// True: a point only moves where that improves the cells round it. False: a redrawn point takes the best
  /// of the new positions.
  bool only_improve = false;
  /// The amplitude of a point that is redrawn again and again shrinks. Unless points only move to improve,
  /// growing neighbourhoods of cells that resist are in the end set to amplitude 0: so redrawing succeeds
  /// whenever the points at amplitude 0 have good cells only.
  bool shrinking = true;
};

struct RedrawOutcome {
  int rounds = 0;
  std::int64_t redrawn_points = 0;
  std::vector<Tetrahedron> remaining;  ///< bad cells that are left; empty on success
};

/// Draws points at bad cells again, one at a time, until every cell is good or the rounds are used up.
///
/// A round goes through the bad cells in ascending order. One point of each is lifted and put where, of some
/// draws, the fewest bad cells and then the best worst quality result; only the cells that this changes are
/// examined. A cell that resists has its other points, then their neighbours redrawn.
/// @param choice decides between points that are equally suitable
RedrawOutcome redraw(Tessellation& tessellation, std::span<const std::uint8_t> movable, const Draw& draw,
                     RandomStream choice, const RedrawRules& rules);

}  // namespace crackle::geometry
