// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_surface.h"
#include "crackle/ensemble/sample_task.h"
#include "crackle/geometry/partition.h"
#include "crackle/io/sample_file.h"

#include <utility>

namespace crackle::ensemble {

SampleSteps make_sample_steps(const input::Parameters& parameters, const geometry::Body& body,
                              const geometry::MotherPoints& base, const std::filesystem::path& folder,
                              int n_ranks, SampleFunction compute) {
  SampleSteps steps;
  steps.make = [&](std::uint64_t sample) {
    return geometry::make_realization(body, base, parameters.mesh, parameters.ensemble.seed, sample);
  };
  steps.split = [](const geometry::Realization& realization, int n_parts) {
    return geometry::split(realization, geometry::partition(realization, n_parts));
  };
  steps.compute = std::move(compute);
  steps.analyse = [&](const geometry::Realization& realization, const dynamics::SampleResult& result) {
    SampleAnalysis analysis;
    analysis.surface = analysis::make_crack_surface(body, realization, result.breaks, result.onset_time);
    analysis.lines = analysis::crack_lines(body, analysis.surface);
    analysis.summary = analysis::summarize(body, result, analysis.surface, analysis.lines,
                                           parameters.material, parameters.sections.y);
    return analysis;
  };
  steps.write = [&parameters, folder, n_ranks](std::uint64_t sample, const geometry::Realization& realization,
                                               const dynamics::SampleResult& result,
                                               const SampleAnalysis& analysis) {
    io::write_sample(io::sample_path(folder, sample),
                     {parameters, sample, realization, result, analysis.surface, analysis.lines,
                      analysis.summary, n_ranks});
  };
  steps.write_failure = [&parameters, folder](std::uint64_t sample, const analysis::SampleSummary& failure) {
    io::write_failed_sample(io::sample_path(folder, sample), parameters, sample, failure);
  };
  steps.failure_row = [&parameters, &body](const std::string& reason) {
    return analysis::empty_summary(body.n_notches(), static_cast<int>(parameters.sections.y.size()),
                                   analysis::SampleStatus::failed, reason);
  };
  return steps;
}

}  // namespace crackle::ensemble
