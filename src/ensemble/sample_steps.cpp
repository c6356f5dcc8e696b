// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_surface.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/sample_task.h"
#include "crackle/geometry/partition.h"
#include "crackle/io/checkpoint_file.h"
#include "crackle/io/sample_file.h"

#include <system_error>
#include <utility>

namespace crackle::ensemble {

SampleSteps make_sample_steps(const input::Parameters& parameters, const geometry::Body& body,
                              const geometry::MotherPoints& base, const std::filesystem::path& folder,
                              int n_ranks, SampleFunction compute) {
  SampleSteps steps;
  steps.make = with_retries([&](std::uint64_t sample, int attempt) {
    return make_sample_mesh(body, base, parameters, sample, attempt);
  });
  steps.split = [&parameters](const geometry::Realization& realization, int n_parts) {
    return geometry::split(realization, geometry::partition(realization, n_parts),
                           parameters.fracture.length);
  };
  steps.compute = std::move(compute);
  steps.analyse = [&](const geometry::Realization& realization, const dynamics::SampleResult& result) {
    SampleAnalysis analysis;
    analysis.surface = analysis::make_crack_surface(body, realization, result.breaks, result.phase_start);
    analysis.lines = analysis::crack_lines(body, analysis.surface);
    analysis.arms = analysis::find_forks(body, analysis.surface);
    analysis.crossings =
        analysis::section_crossings(body, analysis.surface, analysis.arms, parameters.sections);
    analysis.summary = analysis::summarize(body, result, analysis.surface, analysis.lines, analysis.arms,
                                           analysis.crossings, parameters.material);
    analysis.history = analysis::crack_history(body, analysis.surface, analysis.lines, result);
    return analysis;
  };
  steps.write = [&parameters, folder, n_ranks](std::uint64_t sample, const geometry::Realization& realization,
                                               const dynamics::SampleResult& result,
                                               const SampleAnalysis& analysis) {
    io::write_sample(io::sample_path(folder, sample),
                     {parameters, sample, realization, result, analysis.surface, analysis.lines,
                      analysis.arms, analysis.crossings, analysis.summary, analysis.history, n_ranks});
  };
  steps.write_failure = [&parameters, folder, n_ranks](std::uint64_t sample,
                                                       const analysis::SampleSummary& failure,
                                                       const PartialSample* partial) {
    const std::filesystem::path file = io::sample_path(folder, sample);
    if (partial == nullptr) {
      io::write_failed_sample(file, parameters, sample, failure);
    } else {
      io::write_sample(file, {parameters, sample, partial->realization, partial->result,
                              partial->analysis.surface, partial->analysis.lines, partial->analysis.arms,
                              partial->analysis.crossings, failure, partial->analysis.history, n_ranks});
    }
  };
  const auto checkpoint = [folder](std::uint64_t sample) { return io::checkpoint_path(folder, sample); };
  steps.read_checkpoint = [&parameters, checkpoint](std::uint64_t sample) {
    // Bad ones were set aside when the run began; one that has become bad since is of no use either.
    try {
      const std::filesystem::path file = checkpoint(sample);
      if (std::filesystem::exists(file)) return io::read_checkpoint(file, parameters, sample);
    } catch (const std::exception&) {
    }
    return std::vector<std::byte>();
  };
  steps.write_checkpoint = [&parameters, checkpoint](std::uint64_t sample, std::span<const std::byte> bytes) {
    io::write_checkpoint(checkpoint(sample), parameters, sample, bytes);
  };
  steps.remove_checkpoint = [checkpoint](std::uint64_t sample) {
    std::error_code ignored;
    std::filesystem::remove(checkpoint(sample), ignored);
  };
  steps.failure_row = [&parameters, &body](const std::string& reason) {
    return analysis::empty_summary(static_cast<int>(body.crack_starts().size()),
                                   static_cast<int>(parameters.sections.size()),
                                   analysis::SampleStatus::failed, reason);
  };
  return steps;
}

}  // namespace crackle::ensemble
