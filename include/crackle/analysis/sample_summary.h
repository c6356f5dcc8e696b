// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_line.h"
#include "crackle/analysis/crack_path.h"
#include "crackle/dynamics/sample_result.h"
#include "crackle/parallel/communicator.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace crackle::analysis {

enum class SampleStatus : std::int32_t { pending = 0, done = 1, failed = 2 };

/// One sample's row in the ensemble. Of a sample that is not done all results are NaN, 0 or -1.
struct SampleSummary {
  SampleStatus status = SampleStatus::pending;
  std::string error;          ///< reason of a failed sample; why a pending one's file was refused; or empty
  double onset_force = 0;     ///< [N]
  double onset_time = 0;      ///< [s]
  std::int32_t outcome = -1;  ///< dynamics::Outcome; -1 without results
  std::int32_t pattern = 0;   ///< see Pattern
  double overlap = 0;         ///< see pattern_overlap; NaN where there is none
  std::int32_t bifurcations = 0;
  std::int32_t kinks = 0;              ///< of all crack lines
  std::int64_t breaks = 0;             ///< broken tetrahedra
  double crack_area = 0;               ///< all opened dual facets [m^2]
  double crack_speed_max = 0;          ///< [m/s]
  double energy_error = 0;             ///< relative
  double crack_speed_ratio = 0;        ///< crack_speed_max over the Rayleigh speed
  double traced_area = 0;              ///< length of the crack lines times the thickness [m^2]
  double effective_toughness = 0;      ///< released energy over traced_area [J/m^2]; NaN without lines
  std::vector<double> z;               ///< n_notches x n_sections [m], NaN where no crack arrived
  std::vector<double> z_spread;        ///< through the thickness, see SectionCrossing; likewise
  std::vector<std::int32_t> branches;  ///< n_notches x n_sections
  double wall_time = 0;                ///< that the sample took [s]; the only field that differs between runs
};

/// A row for a sample without results: NaN and 0 of the right shape.
SampleSummary empty_summary(int n_notches, int n_sections, SampleStatus status, std::string error = {});

/// @param lines crack_lines of the same surface
SampleSummary summarize(const geometry::Body& body, const dynamics::SampleResult& result,
                        const CrackSurface& surface, const std::vector<CrackLine>& lines,
                        const input::Material& material, std::span<const double> sections);

/// A row as bytes, for messages between ranks of one machine type.
std::vector<std::byte> to_bytes(const SampleSummary& summary);

/// @throws std::runtime_error unless `bytes` are exactly one row
SampleSummary summary_from_bytes(std::span<const std::byte> bytes);

/// The rows of all ranks, in the order of the ranks, on every rank. Collective.
/// @throws parallel::AgreedError on every rank when they are too large for one message
std::vector<SampleSummary> all_gather(const parallel::Communicator& group,
                                      std::span<const SampleSummary> rows);

}  // namespace crackle::analysis
