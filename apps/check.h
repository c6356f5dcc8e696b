// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/quantity_text.h"
#include "dynamics/stable_step.h"
#include "ensemble/estimate.h"
#include "ensemble/memory.h"
#include "ensemble/stand_in.h"
#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"
#include "input/parameters.h"

#include <cstdint>
#include <optional>
#include <string>

/// Parts of `crackle check`.
namespace crackle::apps {

/// Sample 0 and its properties; with a mesh that takes minutes to make, estimates of them.
struct FirstSample {
  const input::Parameters& parameters;
  const geometry::Body& body;
  geometry::Realization realization;
  double mesh_seconds;  ///< to make it, on one core
  dynamics::StableStep stable;
  ensemble::PhaseWork phase;
  std::optional<ensemble::StandIn> stand_in = {};  ///< whose realization this is

  double n_nodes() const {
    return stand_in ? stand_in->n_nodes : static_cast<double>(realization.nodes.size());
  }
  double n_tetrahedra() const {
    return stand_in ? stand_in->n_tetrahedra : static_cast<double>(realization.tetrahedra.size());
  }
  /// Tetrahedra of the sample over those of the realization.
  double ratio() const { return n_tetrahedra() / static_cast<double>(realization.tetrahedra.size()); }
  /// The input to which the realization belongs.
  const input::Parameters& of_realization() const { return stand_in ? stand_in->parameters : parameters; }
  int n_samples() const { return parameters.ensemble.samples; }
  /// Memory of all ranks that share a sample [byte].
  double memory() const;
  /// "1 sample", "200 samples"
  std::string samples_text() const { return count_text(n_samples(), "sample"); }
};

/// @param base receives the shared mother points
/// @param makes_mesh also if that takes minutes
/// @throws std::runtime_error when there is too little memory for the mesh, or no mesh can be made
FirstSample make_subject(const input::Parameters& parameters, const geometry::Body& body,
                         geometry::MotherPoints& base, bool makes_mesh);

/// Prints what is known of sample 0 without computing it.
/// @param crack_speed whose release speed is printed, too [m/s]; 0: none
void print_subject(const FirstSample& subject, const ensemble::AvailableMemory& available,
                   double crack_speed);

/// One-core time of a sample, and what it is in proportion to.
struct SampleTime {
  ensemble::SampleCost cost;
  double n_tetrahedra = 0;
  std::int64_t force_evaluations = 0;  ///< of a dynamic phase
  double share_at_start = 0;           ///< of stress in strength at time 0, the largest
};

/// Measures the cost of sample 0 on this machine and prints it.
/// @param phases expected number of dynamic phases; 0: as such inputs have
/// @param n_ranks number of ranks to plan for; 0: no plan
/// @return nothing if it could not be measured
/// @throws std::runtime_error with the reason if the sample will fail
std::optional<SampleTime> print_cost(const FirstSample& subject, int phases, std::int64_t n_ranks);

/// One-core time of a sample that differs from the measured one in its mesh, expected number of dynamic
/// phases and equilibria excepted [s].
double scaled_seconds(const SampleTime& measured, const FirstSample& subject);

/// Warns if loads from rest are far from breaking the body.
void print_rest_outlook(const FirstSample& subject);

}  // namespace crackle::apps
