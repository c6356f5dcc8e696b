// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/branching.h"
#include "cracks/crack_surface.h"
#include "geometry/realization.h"

#include <vector>

namespace crackle::cracks {

/// Finds the forks of cracks in a body of any shape: where one sheet becomes two.
///
/// A ball of 4.5 local spacings around a place of the crack is cut into pieces: its nodes joined by edges of
/// which no dual facet is opened. Nodes with half of their edges opened join nothing, so that no bridge
/// across the crack does. Three pieces that hold 4 % of the nodes each and reach the ball's border leave
/// three sheets between them, which meet in a line. In a sheet that arrived, facets opened the earlier the
/// farther they are from that line; what lies within a spacing of it does not count. The line is a fork if
/// one sheet arrived and two or more opened later; if none arrived, there are three or more and two opened
/// away from it; or if more opened away than arrived. Where a
/// crack meets or crosses an older one, two sheets arrive or the last one does. Balls with lines within two
/// spacings of each other are of one place: a fork if two of them show it, and more than show that two sheets
/// arrive. The shorter branch must extend over min_branch_length.
///
/// Sheets at 30 to 120 degrees fork, those that stop, bend, run side by side, meet or cross do not. On plates
/// that fork, 95 % of what find_branches finds there with branches of 5 spacings or more is found; one in
/// seven of those found is not among them. On plates that do not fork, nothing is found.
///
/// A fork's place is the mean of its line, its length that of the shorter branch, straight, its time that
/// when half of the later branch in a ball had opened, its angle that between planes through the branches
/// there. It has no share and no parent.
/// @return in order of breaking
std::vector<BranchingPoint> find_forks(const geometry::Realization& realization, const CrackSurface& surface);

}  // namespace crackle::cracks
