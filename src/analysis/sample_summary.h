// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "cracks/crack_line.h"
#include "cracks/front_trajectory.h"
#include "cracks/plane_traces.h"
#include "cracks/section_crossings.h"
#include "dynamics/sample_result.h"
#include "geometry/realization.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

enum class SampleStatus : std::int32_t { pending = 0, done = 1, failed = 2 };

/// A sample's fragments in numbers: pieces of two nodes or more, without dust, unless it says so.
struct FragmentSummary {
  static constexpr double none = not_a_number;
  double body_mass = none;       ///< [kg]
  double number = none;          ///< of fragments
  double largest_mass = none;    ///< [kg]
  double second_mass = none;     ///< of the second largest; 0 if there is one only [kg]
  double mean_mass = none;       ///< [kg]
  double median_mass = none;     ///< [kg]
  double dust_mass = none;       ///< of single nodes [kg]
  double fastest = none;         ///< largest speed of a fragment's mean motion [m/s]
  double kinetic_energy = none;  ///< of the mean motions of all fragments [J]
  double frozen = none;          ///< number of frozen ones, single nodes too
  double frozen_mass = none;     ///< [kg]
  double frozen_energy = none;   ///< taken from them [J]
  /// Number of fragments of at least each of fragment_shares() of the body's mass; empty where unknown.
  std::vector<double> heavier;
};

/// The shares of the body's mass at which fragments are counted: 1e-6, 1.8e-6, 3.2e-6, 5.6e-6, 1e-5, ... 1.
std::vector<double> fragment_shares();

/// One sample's row in the ensemble; sample_results.h defines the results. For samples that are not done all
/// results are NaN, 0 or -1.
struct SampleSummary {
  static constexpr double none = not_a_number;

  SampleStatus status = SampleStatus::pending;
  std::string error;  ///< why a sample failed, or why a pending one's file was rejected; may be empty
  std::string note;   ///< remarks on a completed sample; may be empty
  std::vector<double> inputs;  ///< values of the random inputs, in their order [SI]
  double first_break_time = none;
  double first_break_load = none;
  double first_break_x = none;
  double first_break_y = none;
  double first_break_z = none;
  double onset_time = none;
  double onset_force = none;
  double peak_load = none;
  double displacement_at_peak = none;
  double work_of_fracture = none;
  std::int32_t dynamic_phases = 0;
  double crack_area_before_onset = none;
  std::int32_t outcome = -1;        ///< dynamics::Outcome; -1 without results
  std::int32_t held = 0;            ///< see is_held
  std::int32_t pattern = 0;         ///< see Pattern
  std::int32_t leading_start = -1;  ///< see cracks::leading_start
  std::int32_t hole = -1;           ///< see LeadersHole
  std::int32_t hole_passage = 0;    ///< likewise
  double overlap = none;            ///< see pattern_overlap
  std::int32_t branching_points = 0;
  std::int32_t long_branching_points = 0;
  std::int32_t branching_points_projected = 0;
  std::int32_t kinks = 0;
  std::int64_t breaks = 0;
  double crack_area = none;
  std::vector<double> crack_area_in;  ///< of the parts of a body, see crack_parts [m^2]; may be empty
  double crack_speed_max = none;
  double crack_speed_ratio = none;
  double traced_area = none;
  double effective_toughness = none;
  double energy_error = none;
  double equilibrium_residual = none;
  std::vector<double> position;            ///< n_starts x n_sections, see SectionCrossing
  std::vector<double> z_spread;            ///< likewise
  std::vector<double> arrival_time;        ///< likewise
  std::vector<std::int32_t> branches;      ///< likewise
  std::vector<cracks::StartTrace> traces;  ///< cracks::start_traces; empty where they are not known
  FragmentSummary fragments;
  double wall_time = 0;  ///< of the sample [s]; the only field that differs between runs
};

/// True for a completed sample that was still breaking when it ended: its loads and cracks are unfinished.
inline bool is_undecided(const SampleSummary& row) {
  return row.status == SampleStatus::done &&
         row.outcome == static_cast<std::int32_t>(dynamics::Outcome::undecided);
}

/// True for a completed sample whose body came apart.
inline bool is_separated(const SampleSummary& row) {
  return row.status == SampleStatus::done &&
         row.outcome == static_cast<std::int32_t>(dynamics::Outcome::separated);
}

/// True for a completed sample in which nothing broke: it is stronger than its loads, by how much is unknown.
inline bool is_unbroken(const SampleSummary& row) {
  return row.status == SampleStatus::done &&
         row.outcome == static_cast<std::int32_t>(dynamics::Outcome::unbroken);
}

/// True for a completed sample whose cracks arrested, and whose load was at its largest when the loading
/// ended: it bears more than that.
inline bool is_held(const SampleSummary& row) {
  return row.status == SampleStatus::done && row.held == 1;
}

/// True for a sample with more than two fragments: bodies that only come apart leave two of them, dust and
/// crumbs, of less than 1 % of the mass together.
inline bool is_fragmented(const SampleSummary& row) {
  const FragmentSummary& found = row.fragments;
  return row.status == SampleStatus::done &&
         found.body_mass - found.largest_mass - found.second_mass - found.dust_mass >= 0.01 * found.body_mass;
}

/// A row for a sample without results: NaN and 0 in the right shape.
SampleSummary empty_summary(int n_starts, int n_sections, SampleStatus status, std::string error = {});

/// @param lines crack_lines of the same surface
/// @param branches find_branches or find_forks of it
/// @param crossings section_crossings of it
/// @param trajectories front_trajectories of it
SampleSummary summarize(const geometry::Body& body, const dynamics::SampleResult& result,
                        const cracks::CrackSurface& surface, const std::vector<cracks::CrackLine>& lines,
                        const cracks::CrackBranches& branches,
                        const std::vector<cracks::SectionCrossing>& crossings,
                        std::span<const cracks::FrontTrajectory> trajectories);

/// From which branches are long [m]: the input's length, or 4 spacings of the mesh where cracks run.
double branch_length(double given, const input::Mesh& mesh, const geometry::Body& body);

/// The parts of a body of several materials among which the area of its cracks is divided: the materials by
/// name, then "interface A-B" of each [[interface]]. Empty if there is only one material.
std::vector<std::string> crack_parts(const std::vector<input::Material>& materials,
                                     const std::vector<input::Interface>& interfaces);

/// The area of a crack surface in each of these parts [m^2]. At an interface are the tetrahedra that have its
/// toughness or strength: those that touch it.
std::vector<double> crack_area_in_parts(const cracks::CrackSurface& surface,
                                        const geometry::Realization& realization,
                                        const std::vector<input::Material>& materials,
                                        const std::vector<input::Interface>& interfaces);

/// The fragments at the end in numbers.
FragmentSummary summarize_fragments(const dynamics::SampleResult& result);

/// Replaces the row's crossings by those at other sections.
void measure_crossings(const geometry::Body& body, const cracks::CrackSurface& surface,
                       const input::Sections& sections, SampleSummary& row);

/// The rows of all ranks, in rank order, on the root; empty elsewhere. Collective.
/// @throws parallel::AgreedError on every rank when they are too large for one message
std::vector<SampleSummary> gather_on_root(const parallel::Communicator& group,
                                          std::span<const SampleSummary> rows);

/// Cracks hardly ever run faster, relative to the Rayleigh speed where they run.
inline constexpr double usual_speed_ratio = 0.85;

/// Warnings of cracks above usual_speed_ratio and of onsets below the peak load.
std::vector<std::string> ensemble_warnings(std::span<const SampleSummary> samples);

/// Name of the result that tells what the samples held: onset_force; peak_load if a sample's load was clearly
/// higher before its onset, of which ensemble_warnings warn, or if none broke; first_break_load if none has
/// an onset.
const char* headline_load(std::span<const SampleSummary> samples);

}  // namespace crackle::analysis
