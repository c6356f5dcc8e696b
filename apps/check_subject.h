// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/quantity_text.h"
#include "crackle/ensemble/estimate.h"
#include "crackle/ensemble/memory.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/parameters.h"

#include <fmt/format.h>

#include <string>

namespace crackle::apps {

/// Sample 0 and its properties.
struct FirstSample {
  const input::Parameters& parameters;
  const geometry::Body& body;
  geometry::Realization realization;
  double stable_step;  ///< [s]
  ensemble::PhaseWork phase;
  double rest_seconds;  ///< on one core: mesh, stable step, crack analysis and output

  double n_nodes() const { return static_cast<double>(realization.nodes.size()); }
  double n_tetrahedra() const { return static_cast<double>(realization.tetrahedra.size()); }
  int n_samples() const { return parameters.ensemble.samples; }
  /// Memory of all ranks that share a sample [byte].
  double memory() const;
  /// "1 sample", "200 samples"
  std::string samples_text() const { return count_text(n_samples(), "sample"); }
};

/// @param base receives the shared mother points
/// @throws std::runtime_error when there is too little memory for the mesh, or no mesh can be made
FirstSample make_subject(const input::Parameters& parameters, const geometry::Body& body,
                         geometry::MotherPoints& base);

/// Prints what is known of sample 0 without computing it.
/// @param crack_speed whose release speed is printed, too [m/s]; 0: none
void print_subject(const FirstSample& subject, const ensemble::AvailableMemory& available,
                   double crack_speed);

}  // namespace crackle::apps
