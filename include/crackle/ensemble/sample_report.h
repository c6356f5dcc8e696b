// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/sample_results.h"
#include "crackle/dynamics/sample_result.h"

#include <concepts>
#include <cstdint>
#include <string>
#include <vector>

namespace crackle::ensemble {

/// What a group tells the master about a sample that ended.
struct SampleReport {
  std::uint64_t sample = 0;
  analysis::SampleSummary summary;
  bool stored = false;  ///< a whole sample file tells the same; without one, a resumed run computes it again
  bool parked = false;  ///< stopped on the way as asked: neither done nor failed
  std::string
      checkpoint_error;  ///< of a parked sample: why its last checkpoint could not be kept; mostly empty
  int mesh_attempt = 0;  ///< that gave the realization; shown when it is not 0
  std::int64_t n_tetrahedra = 0;
  double seconds = 0;  ///< wall time from the realization's arrival to the file
};

/// For a Packer: messages between ranks of one machine type.
void for_each_field(std::derived_from<SampleReport> auto& report, const auto& visit) {
  visit(report.sample, report.stored, report.parked, report.checkpoint_error, report.mesh_attempt,
        report.n_tetrahedra, report.seconds, report.summary);
}

/// One line for the log: sample number, onset force, pattern, crack area, breaks, energy error, seconds; or
/// the reason of a failure.
std::string describe(const SampleReport& report);

/// Lines on the mechanics of one sample: outcome, onset, breaks, energy error, work and speed.
std::vector<std::string> describe(const dynamics::SampleResult& result);

}  // namespace crackle::ensemble
