// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sample_task.h"

#include "crackle/common/failure.h"
#include "crackle/common/stopwatch.h"
#include "crackle/parallel/agreement.h"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <utility>

namespace crackle::ensemble {

namespace {

/// The mechanics on this rank of the group; either all ranks return or all throw AgreedError.
/// @param partial receives the available results of a sample that fails
/// @param checkpoint_error on the root: why the last checkpoint could not be written; empty on success
dynamics::SampleResult compute_agreed(SampleGroup& group, const SampleSteps& steps, std::uint64_t sample,
                                      const geometry::Subdomain& subdomain,
                                      std::optional<dynamics::SampleResult>& partial,
                                      std::string& checkpoint_error) {
  dynamics::SampleResult result;
  const auto control = parallel::agree(group.control(), [&] {
    dynamics::SampleControl given{
        .sample = sample,
        .log = steps.log,
        .progress = steps.progress,
        .stop = steps.stop,
        .save = {},
        .checkpoint = {},
        .checkpoint_interval = steps.checkpoint_interval,
        .failed = [&](dynamics::SampleResult unfinished) { partial = std::move(unfinished); }};
    if (steps.write_checkpoint) {
      given.save = [&](std::span<const std::byte> bytes) {
        checkpoint_error.clear();
        try {
          steps.write_checkpoint(sample, bytes);
        } catch (...) {
          checkpoint_error = parallel::current_error();
          throw;
        }
      };
      if (group.is_root()) given.checkpoint = steps.read_checkpoint(sample);
    }
    return given;
  });
  std::optional<std::string> error;
  try {
    result = steps.compute(group.computation(), sample, subdomain, control);
  } catch (...) {
    error = parallel::current_error(group.control());
  }
  try {
    parallel::agree_on_error(group.control(), error);
  } catch (const parallel::AgreedError&) {
    group.renew();
    throw;
  }
  return result;
}

/// Reports the stages of a sample to the hook.
void begin(SampleGroup& group, const SampleSteps& steps, std::uint64_t sample) {
  parallel::Communicator::StageHook hook;
  if (steps.enter) hook = [&steps, sample](std::string_view stage) { steps.enter(sample, stage); };
  group.on_stage(std::move(hook));
}

/// A step's failure, prefixed with the name of the step: the sample has failed, the run goes on.
class StepError : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

template <class Step>
auto staged(const char* stage, Step&& step) {
  try {
    return step();
  } catch (...) {
    throw StepError(std::string(stage) + ": " + parallel::current_error());
  }
}

/// Runs a step on this rank only.
template <class Step>
auto staged(const SampleGroup& group, const char* stage, Step&& step) {
  return staged(stage, [&] {
    group.computation().enter(stage);
    return step();
  });
}

}  // namespace

SampleReport report_failure(const SampleSteps& steps, std::uint64_t sample, const std::string& reason,
                            double seconds, const PartialSample* partial) {
  SampleReport report;
  report.sample = sample;
  report.seconds = seconds;
  report.summary = steps.failure_row(sample, reason);
  try {
    steps.write_failure(sample, report.summary, partial);
    report.stored = true;
    // A state that led to a failure must not be resumed.
    if (steps.remove_checkpoint) steps.remove_checkpoint(sample);
  } catch (...) {
    report.summary.error += "; this could not be written either: " + parallel::current_error();
  }
  return report;
}

SampleReport lead_sample(SampleGroup& group, const SampleSteps& steps, PreparedSample prepared) {
  const Stopwatch clock;
  const std::uint64_t sample = prepared.sample;
  const geometry::Realization& realization = prepared.realization;
  dynamics::SampleResult result;
  std::optional<dynamics::SampleResult> partial;
  std::string checkpoint_error;
  SampleAnalysis analysis;
  begin(group, steps, sample);
  try {
    auto parts = staged(group, "partition", [&] {
      if (steps.log)
        steps.log(fmt::format(
            "sample {}: realization made in {:.2f} s, worst quality {:.3f}, {} points redrawn", sample,
            prepared.seconds, realization.report.min_quality, realization.report.redrawn_points));
      auto split = steps.split(sample, realization, group.size());
      if (split.size() != static_cast<std::size_t>(group.size()))
        fail("{} parts for {} ranks", split.size(), group.size());
      return split;
    });
    try {
      send_shares(group, sample, parts);
    } catch (const parallel::AgreedError& failure) {
      fail<StepError>("sharing: {}", failure.what());
    }
    result = staged("computation", [&] {
      return compute_agreed(group, steps, sample, parts[0], partial, checkpoint_error);
    });
    if (result.suspended) {
      SampleReport report;
      report.sample = sample;
      report.parked = true;
      report.checkpoint_error = checkpoint_error;
      report.seconds = clock.seconds();
      return report;
    }
    result.timings.mesh = prepared.seconds;
    analysis = staged(group, "analysis", [&] {
      if (steps.log)
        for (const auto& line : describe(result)) steps.log(line);
      return steps.analyse(sample, realization, result);
    });
  } catch (const StepError& failure) {
    if (!partial) return report_failure(steps, sample, failure.what(), clock.seconds());
    try {
      analysis = steps.analyse(sample, realization, *partial);
    } catch (...) {  // keep mesh, breaks and frames without the analysis
    }
    const PartialSample kept{realization, *partial, analysis};
    return report_failure(steps, sample, failure.what(), clock.seconds(), &kept);
  }

  SampleReport report;
  report.sample = sample;
  report.mesh_attempt = realization.report.attempt;
  report.n_tetrahedra = static_cast<std::int64_t>(realization.tetrahedra.size());
  try {
    staged(group, "writing", [&] { steps.write(sample, realization, result, analysis); });
    report.summary = std::move(analysis.summary);
    report.stored = true;
    if (steps.remove_checkpoint) steps.remove_checkpoint(sample);
  } catch (const StepError& failure) {
    report.summary = steps.failure_row(sample, failure.what());
  }
  report.seconds = clock.seconds();
  return report;
}

void follow_samples(SampleGroup& group, const SampleSteps& steps) {
  while (const auto header = receive_header(group)) {
    begin(group, steps, header->sample);
    try {
      const auto part = receive_share(group, *header);
      std::optional<dynamics::SampleResult> partial;
      std::string checkpoint_error;
      compute_agreed(group, steps, header->sample, part, partial, checkpoint_error);
    } catch (const parallel::AgreedError&) {
      // The root has the same error and reports it.
    }
  }
}

}  // namespace crackle::ensemble
