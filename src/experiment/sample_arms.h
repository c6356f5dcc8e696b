// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/experiment/observation.h"

namespace crackle::experiment {

/// The symmetry that maps one crack start onto another; null if there is none.
const geometry::Symmetry* symmetry_to(const std::vector<geometry::Symmetry>& symmetries, int from, int to);

plane::Point image_of(const geometry::Symmetry& symmetry, const plane::Point& p);

/// The arm from a crack start that runs longest in the box and half its size around it, or the only one; null
/// if there is none.
const TimedLine* arm_in_sight(const ObservedSample& sample, int start, const plane::Bounds& box);

/// By how much arms are drawn out at both ends: a crack line is known up to half a slab, in which it may well
/// go on [m].
double drawn_out_by(const TimedLine& arm);

/// When the crack arrived at the point of its arm that is nearest to a place [s]; NaN if it ended before.
double arrival_at(const TimedLine& arm, const plane::Point& place);

}  // namespace crackle::experiment
