// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "dynamics/energy_account.h"
#include "dynamics/sample_result.h"
#include "mechanics/conditions.h"

#include <span>
#include <utility>
#include <vector>

/// A sample's results as a testing machine would record them.
///
/// - Load: the sum of the forces that the governing conditions (mechanics::governing_conditions) exert on the
///   body, each along its own drive. Positive if the machine loads the body, negative if the body pushes back
///   against a pulling grip. For a pressure it is the pressure times the area, for a body force its
///   resultant, for a rotation the sum of the magnitudes of its forces.
/// - Displacement: along the drive, averaged over these conditions; the prescribed value for prescribed
///   motions, otherwise the mean over the loaded area or body, weighted with a factor.
/// - Peak load: the largest load up to separation, in dynamic phases at 200 moments or more of the duration
///   and where loads turn; of applied loads exactly. In a dynamic phase after quasi-static loading, a
///   reaction does not count while it exceeds the static force for the current displacement, with the
///   stiffness at the start of the phase: fracture cannot stiffen the body, so the excess is inertia, which
///   no load cell would follow.
/// - Displacement at peak: when the load first comes within 0.1 % of its peak; it ends there if its last
///   value is within that.
/// - Work of fracture: the external work of all loads up to separation, or to the end of the history of a
///   body that stays in one piece.
/// - Separation: when two boundary conditions no longer act on a common piece; parts connected by nodes or
///   edges only count as separate. Fragments that fly apart and rebound afterwards remain in the history.
namespace crackle::dynamics {

struct Load {
  double force = 0;         ///< [N]
  double displacement = 0;  ///< [m]
};

/// The machine's load and displacement.
Load machine_load(const mechanics::Conditions& loads, const LoadState& state);

/// The largest force applied by any condition, or reaction of a prescribed motion other than `fix` [N].
double largest_load(const mechanics::Conditions& loads, const LoadState& state);

/// From the moments of the history; NaN without any.
LoadResults load_results(const SampleResult& result);

/// The machine's displacement at a load time between two moments of the history, linear in time [m].
double load_displacement_at(std::span<const HistoryRow> history, double load_time);

/// The intervals of load time between consecutive moments of a dynamic phase, up to separation [s].
std::vector<std::pair<double, double>> dynamic_intervals(const SampleResult& result);

}  // namespace crackle::dynamics
