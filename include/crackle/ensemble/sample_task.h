// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/analysis/crack_history.h"
#include "crackle/common/real.h"
#include "crackle/dynamics/sample_run.h"
#include "crackle/ensemble/realization_queue.h"
#include "crackle/ensemble/sample_group.h"
#include "crackle/ensemble/sample_report.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace crackle::ensemble {

/// The mechanics of one sample, normally dynamics::run_sample; a parameter so that tests can inject faults.
/// Collective over the group. If a rank fails, no other rank may wait for it: either all ranks throw, or the
/// others return.
using SampleFunction = std::function<dynamics::SampleResult(
    const parallel::Communicator& group, std::uint64_t sample, const geometry::Subdomain& subdomain,
    const dynamics::SampleControl& control)>;

/// Results of a sample derived from its mechanics.
struct SampleAnalysis {
  analysis::CrackSurface surface;
  std::vector<analysis::CrackLine> lines;
  analysis::CrackBranches branches;
  std::vector<analysis::SectionCrossing> crossings;  ///< notches x sections
  analysis::SampleSummary summary;
  analysis::CrackHistory history;
};

/// Available data of a sample that failed part-way.
struct PartialSample {
  const geometry::Realization& realization;
  const dynamics::SampleResult& result;
  const SampleAnalysis& analysis;
};

/// The steps of processing one sample. An exception in a step fails that sample only.
struct SampleSteps {
  /// Makes the realization; the master calls it from a separate thread.
  RealizationMaker make;
  /// Makes one subdomain for each rank of the group; on the group's root.
  std::function<std::vector<geometry::Subdomain>(std::uint64_t sample,
                                                 const geometry::Realization& realization, int n_parts)>
      split;
  /// The mechanics, on all ranks of the group.
  SampleFunction compute;
  /// Derives the crack surface and the ensemble row from the mechanics; on the group's root.
  std::function<SampleAnalysis(std::uint64_t sample, const geometry::Realization& realization,
                               const dynamics::SampleResult& result)>
      analyse;
  /// Writes the sample's file; on the group's root.
  std::function<void(std::uint64_t sample, const geometry::Realization& realization,
                     const dynamics::SampleResult& result, const SampleAnalysis& analysis)>
      write;
  /// Writes a failure to the sample's file, with the available mechanics (nullptr: none); on the group's
  /// root, or on the master if no realization was made.
  std::function<void(std::uint64_t sample, const analysis::SampleSummary& failure,
                     const PartialSample* partial)>
      write_failure;
  /// A row without results, for a failed sample.
  std::function<analysis::SampleSummary(std::uint64_t sample, const std::string& reason)> failure_row;
  /// Lines about the progress of a sample; on the group's root.
  dynamics::SampleLog log;
  /// See dynamics::SampleControl. schedule_samples() forwards it from the root of a single group to rank 0.
  dynamics::SampleLog progress;
  /// Called at the start of each stage of a sample's local work, on every rank that does it; an exception
  /// fails the sample. For tests; may be empty.
  std::function<void(std::uint64_t sample, std::string_view stage)> enter;
  /// True if this rank was asked to park its sample; may be empty.
  std::function<bool()> stop;
  /// Checkpoints of samples under way; all three on the group's root, and either all set on every rank or all
  /// empty. An empty checkpoint means none.
  std::function<std::vector<std::byte>(std::uint64_t sample)> read_checkpoint;
  std::function<void(std::uint64_t sample, std::span<const std::byte> checkpoint)> write_checkpoint;
  std::function<void(std::uint64_t sample)> remove_checkpoint;
  double checkpoint_interval = infinity;  ///< wall time [s]
};

/// The steps of a real sample: geometry, crack surface and summary, files in `folder`/samples.
/// The references must outlive the steps.
/// @param base points shared by all samples; unused with mesh.base = "own"
/// @param n_ranks of a group, recorded in the files
SampleSteps make_sample_steps(const input::Parameters& parameters, const geometry::Body& body,
                              const geometry::MotherPoints& base, const std::filesystem::path& folder,
                              int n_ranks, SampleFunction compute);

/// Reports a failed sample and, if possible, records the failure in its file and removes its checkpoint.
/// @param seconds spent on the sample
/// @param partial available data; nullptr: none
SampleReport report_failure(const SampleSteps& steps, std::uint64_t sample, const std::string& reason,
                            double seconds, const PartialSample* partial = nullptr);

/// Root of the group: processes one sample from its realization to its file. Collective over the group,
/// together with follow_samples on the other ranks. A sample that cannot be written is reported as failed and
/// leaves no file, so that a resumed run recomputes it. A sample that was asked to park is reported as
/// parked.
SampleReport lead_sample(SampleGroup& group, const SampleSteps& steps, PreparedSample prepared);

/// Other ranks of the group: takes part in every sample that the root leads, until send_end.
void follow_samples(SampleGroup& group, const SampleSteps& steps);

}  // namespace crackle::ensemble
