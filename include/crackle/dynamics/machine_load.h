// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/dynamics/energy_account.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/mechanics/boundary_loads.h"

#include <vector>

/// A sample's results as a testing machine would record them.
///
/// - Load: the force that the governing conditions (mechanics::governing_conditions) exert on the body, each
///   along its own drive, added up. It is positive where the machine loads the body, and negative where the
///   body pushes back against a grip that pulls. Of a pressure it is the pressure times the area.
/// - Displacement: along the drive, the mean of these conditions; of prescribed motions what they prescribe,
///   of the others the mean over the loaded area.
/// - Peak load: the largest load up to separation. In a dynamic phase that follows quasi-static loading a
///   reaction counts up to that of the stiffness at the start of the phase, at the displacement then: a body
///   that breaks gets no stiffer, so what is more is inertia, which no load cell follows.
/// - Displacement at peak: when the load first comes within 0.1 % of its peak.
/// - Work of fracture: the external work of all loads up to separation, or to the end of the history of a
///   body that stays in one piece.
/// - Separation: from then on two boundary conditions act on no common piece; what hangs by nodes or edges
///   only is in two. What flies apart and rebounds afterwards stays in the history.
namespace crackle::dynamics {

struct Load {
  double force = 0;         ///< [N]
  double displacement = 0;  ///< [m]
};

/// The machine's load and displacement.
Load machine_load(const mechanics::BoundaryLoads& loads, const LoadState& state);

/// The largest force that any condition applies, or reaction of a prescribed motion other than `fix` [N].
double largest_load(const mechanics::BoundaryLoads& loads, const LoadState& state);

struct LoadResults {
  double peak_load = not_a_number;             ///< [N]
  double displacement_at_peak = not_a_number;  ///< [m]
  double work_of_fracture = not_a_number;      ///< [J]
};

/// NaN where there is no history.
LoadResults load_results(const SampleResult& result);

}  // namespace crackle::dynamics
