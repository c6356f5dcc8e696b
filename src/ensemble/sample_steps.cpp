// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_surface.h"
#include "crackle/common/real.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/sample_inputs.h"
#include "crackle/ensemble/sample_task.h"
#include "crackle/geometry/partition.h"
#include "crackle/io/checkpoint_file.h"
#include "crackle/io/sample_file.h"
#include "crackle/uncertainty/random_inputs.h"

#include <system_error>
#include <utility>

namespace crackle::ensemble {

SampleSteps make_sample_steps(const input::Parameters& parameters, const geometry::Body& body,
                              const geometry::MotherPoints& base, const std::filesystem::path& folder,
                              int n_ranks, SampleFunction compute) {
  SampleSteps steps;
  const auto inputs = std::make_shared<const SampleInputs>(parameters, body);
  steps.make = [&base, inputs](std::uint64_t sample) {
    const auto input = inputs->of(sample);
    return with_retries([&](std::uint64_t number, int attempt) {
      return make_sample_mesh(*input->body, base, input->parameters, number, attempt);
    })(sample);
  };
  steps.split = [inputs](std::uint64_t sample, const geometry::Realization& realization, int n_parts) {
    return geometry::split(realization, geometry::partition(realization, n_parts),
                           inputs->of(sample)->parameters.fracture.length);
  };
  steps.compute = std::move(compute);
  steps.analyse = [inputs](std::uint64_t sample, const geometry::Realization& realization,
                           const dynamics::SampleResult& result) {
    const auto input = inputs->of(sample);
    const geometry::Body& own_body = *input->body;
    const input::Parameters& own = input->parameters;
    SampleAnalysis analysis;
    analysis.surface = analysis::make_crack_surface(own_body, realization, result.breaks, result.phase_start);
    analysis.branches = analysis::find_branches(own_body, analysis.surface);
    analysis.lines = analysis::crack_lines(own_body, analysis.surface, analysis.branches);
    analysis.crossings =
        analysis::section_crossings(own_body, analysis.surface, analysis.branches, own.sections);
    analysis.summary = analysis::summarize(own_body, result, analysis.surface, analysis.lines,
                                           analysis.branches, analysis.crossings, own.material);
    if (own.draw) analysis.summary.inputs = own.draw->values;
    analysis.history = analysis::crack_history(own_body, analysis.surface, analysis.lines, result);
    return analysis;
  };
  steps.write = [inputs, folder, n_ranks](std::uint64_t sample, const geometry::Realization& realization,
                                          const dynamics::SampleResult& result,
                                          const SampleAnalysis& analysis) {
    io::write_sample(
        io::sample_path(folder, sample),
        {inputs->of(sample)->parameters, sample, realization, result, analysis.surface, analysis.lines,
         analysis.branches, analysis.crossings, analysis.summary, analysis.history, n_ranks});
  };
  steps.write_failure = [&parameters, inputs, folder, n_ranks](std::uint64_t sample,
                                                               const analysis::SampleSummary& failure,
                                                               const PartialSample* partial) {
    const std::filesystem::path file = io::sample_path(folder, sample);
    if (partial == nullptr) {
      io::write_failed_sample(file, parameters, sample, failure);
    } else {
      io::write_sample(file, {inputs->of(sample)->parameters, sample, partial->realization, partial->result,
                              partial->analysis.surface, partial->analysis.lines, partial->analysis.branches,
                              partial->analysis.crossings, failure, partial->analysis.history, n_ranks});
    }
  };
  const auto checkpoint = [folder](std::uint64_t sample) { return io::checkpoint_path(folder, sample); };
  steps.read_checkpoint = [&parameters, checkpoint](std::uint64_t sample) {
    // Bad checkpoints were renamed at the start of the run; one that has become unreadable since is ignored.
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
  steps.failure_row = [&parameters, &body](std::uint64_t sample, const std::string& reason) {
    auto row = analysis::empty_summary(static_cast<int>(body.crack_starts().size()),
                                       static_cast<int>(parameters.sections.size()),
                                       analysis::SampleStatus::failed, reason);
    try {
      row.inputs = uncertainty::drawn_values(parameters, sample);
    } catch (...) {  // may be the cause of the failure
      row.inputs.assign(parameters.random.size(), not_a_number);
    }
    return row;
  };
  return steps;
}

}  // namespace crackle::ensemble
