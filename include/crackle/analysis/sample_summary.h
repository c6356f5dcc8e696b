// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_path.h"
#include "crackle/dynamics/sample_result.h"

#include <cstdint>
#include <string>
#include <vector>

namespace crackle::analysis {

enum class SampleStatus : std::int32_t { pending = 0, done = 1, failed = 2 };

/// One sample's row in the ensemble.
struct SampleSummary {
  SampleStatus status = SampleStatus::pending;
  std::string error;         ///< reason of a failed sample, empty otherwise
  double onset_force = 0;    ///< [N]
  double onset_time = 0;     ///< [s]
  std::int32_t pattern = 0;  ///< see Pattern
  std::int32_t bifurcations = 0;
  double crack_area = 0;               ///< [m^2]
  double crack_speed_max = 0;          ///< [m/s]
  double energy_error = 0;             ///< relative
  std::vector<double> z;               ///< n_notches x n_sections [m], NaN where no crack arrived
  std::vector<std::int32_t> branches;  ///< n_notches x n_sections
};

/// A row for a sample without results: NaN and 0 of the right shape.
SampleSummary empty_summary(int n_notches, int n_sections, SampleStatus status, std::string error = {});

SampleSummary summarize(const geometry::Body& body, const dynamics::SampleResult& result,
                        const CrackSurface& surface, std::span<const double> sections);

}  // namespace crackle::analysis
