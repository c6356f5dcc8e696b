// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/result_list.h"
#include "dynamics/sample_result.h"

#include <concepts>
#include <cstdint>
#include <string>
#include <vector>

namespace crackle::ensemble {

/// Report of a group to the master about a sample that ended.
struct SampleReport {
  std::uint64_t sample = 0;
  analysis::SampleSummary summary;
  bool stored =
      false;  ///< a complete sample file contains the same; otherwise a resumed run recomputes the sample
  bool suspended = false;        ///< stopped part-way on request: neither done nor failed
  std::string checkpoint_error;  ///< of a suspended sample: why its last checkpoint could not be written;
                                 ///< usually empty
  int mesh_attempt = 0;          ///< attempt that gave the realization; shown unless 0
  std::int64_t n_tetrahedra = 0;
  double wave_transit = 0;  ///< see dynamics::wave_transit; 0: not known [s]
  double seconds = 0;       ///< wall time from receiving the realization to writing the file
};

/// For a Packer: messages between ranks of the same architecture.
void for_each_field(std::derived_from<SampleReport> auto& report, const auto& visit) {
  visit(report.sample, report.stored, report.suspended, report.checkpoint_error, report.mesh_attempt,
        report.n_tetrahedra, report.wave_transit, report.seconds, report.summary);
}

/// One line for the log: sample number, onset force, pattern, crack area, breaks, energy error, seconds; or
/// the reason for a failure.
std::string describe(const SampleReport& report);

/// Lines on the mechanics of one sample: outcome, onset, breaks, energy error, work and speed.
std::vector<std::string> describe(const dynamics::SampleResult& result);

}  // namespace crackle::ensemble
