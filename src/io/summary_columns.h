// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_summary.h"

namespace crackle::io {

/// Calls visit(name, member, units) for every scalar result of a sample: /summary/<name> in its own file,
/// /samples/<name> in the ensemble's.
template <class Visit>
void for_each_result(Visit&& visit) {
  using Row = analysis::SampleSummary;
  visit("onset_force", &Row::onset_force, "N");
  visit("onset_time", &Row::onset_time, "s");
  visit("outcome", &Row::outcome, "");
  visit("pattern", &Row::pattern, "");
  visit("overlap", &Row::overlap, "1");
  visit("bifurcations", &Row::bifurcations, "");
  visit("kinks", &Row::kinks, "");
  visit("breaks", &Row::breaks, "");
  visit("crack_area", &Row::crack_area, "m^2");
  visit("crack_speed_max", &Row::crack_speed_max, "m/s");
  visit("energy_error", &Row::energy_error, "1");
  visit("crack_speed_ratio", &Row::crack_speed_ratio, "1");
  visit("traced_area", &Row::traced_area, "m^2");
  visit("effective_toughness", &Row::effective_toughness, "J/m^2");
}

/// Calls visit(name, member, units) for every result with notches x sections values for each sample:
/// /summary/<name> in its own file, /crack_path/<name> in the ensemble's.
template <class Visit>
void for_each_position_result(Visit&& visit) {
  using Row = analysis::SampleSummary;
  visit("z", &Row::z, "m");
  visit("z_spread", &Row::z_spread, "m");
  visit("branches", &Row::branches, "");
}

}  // namespace crackle::io
