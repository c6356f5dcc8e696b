// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/group.h"
#include "common/failure.h"
#include "common/index.h"
#include "common/quantity_text.h"
#include "common/stopwatch.h"
#include "parallel/agreement.h"
#include "parallel/message.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace crackle::ensemble {

int GroupLayout::group_of(int rank) const {
  if (shared()) return 0;
  if (rank == 0) return -1;
  const int group = (rank - 1) / ranks_per_group;
  return group < n_groups ? group : -1;
}

GroupLayout make_group_layout(int n_ranks, int ranks_per_sample) {
  if (n_ranks == 1) return {};
  if (n_ranks < 1 + ranks_per_sample) {
    fail(
        "ensemble.ranks_per_sample = {0} needs at least {1} ranks (a master and one group of {0}), "
        "but there are {2}; start {1} or more, or 1",
        ranks_per_sample, 1 + ranks_per_sample, n_ranks);
  }
  GroupLayout layout;
  layout.n_ranks = n_ranks;
  layout.ranks_per_group = ranks_per_sample;
  layout.n_groups = (n_ranks - 1) / ranks_per_sample;
  layout.n_left_over = (n_ranks - 1) % ranks_per_sample;
  return layout;
}

GroupLayout one_group(int n_ranks) {
  return {.n_ranks = n_ranks, .ranks_per_group = n_ranks, .n_groups = 1, .n_left_over = 0};
}

std::string describe(const GroupLayout& layout) {
  if (layout.shared()) return "1 rank: master and worker in one";
  std::string line = fmt::format("{} ranks: master on rank 0, {} of {}", layout.n_ranks,
                                 count_text(layout.n_groups, "group"), layout.ranks_per_group);
  if (layout.n_left_over > 0) {
    const int first = layout.n_ranks - layout.n_left_over;
    line += layout.n_left_over == 1 ? fmt::format("; rank {} stays idle", first)
                                    : fmt::format("; ranks {} to {} stay idle", first, layout.n_ranks - 1);
  }
  return line;
}

namespace {

constexpr int share_tag = 1;
constexpr const char* sharing_stage = "sharing";

/// Calls work(array) for each array of a subdomain, in the order of transmission.
template <class Part, class Work>
void for_each_array_of(Part& part, const Work& work) {
  geometry::for_each_array(part, work);
  work(part.layout.number);
  work(part.layout.ghosts);
  work(part.layout.first_owned);
  work(part.tetrahedron_number);
  work(part.owned);
  work(part.boundary_number);
}

using StepsMaker = std::function<SampleSteps&()>;

/// The mechanics on this rank of the group; either all ranks return or all throw AgreedError.
/// @param partial receives the available results of a sample that fails
/// @param checkpoint_error on the root: why the last checkpoint could not be written; empty on success
dynamics::SampleResult compute_agreed(SampleGroup& group, const dynamics::SampleControl& control,
                                      const StepsMaker& steps_of, const geometry::Subdomain& subdomain,
                                      std::optional<dynamics::SampleResult>& partial,
                                      std::string& checkpoint_error) {
  dynamics::SampleResult result;
  SampleSteps* steps = nullptr;
  auto given = parallel::agree(group.control(), [&] {
    steps = &steps_of();
    dynamics::SampleControl own = control;
    own.failed = [&](dynamics::SampleResult unfinished) { partial = std::move(unfinished); };
    if (!steps->keeps_checkpoints()) return own;
    own.save = [&, steps](std::span<const std::byte> bytes) {
      checkpoint_error.clear();
      try {
        steps->write_checkpoint(bytes);
      } catch (...) {
        checkpoint_error = parallel::current_error();
        throw;
      }
    };
    if (group.is_root()) own.checkpoint = steps->read_checkpoint();
    return own;
  });
  std::optional<std::string> error;
  try {
    result = steps->compute(group.computation(), subdomain, std::move(given));
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

/// Reports the stages of a sample to the source.
void begin(SampleGroup& group, SampleSource& source, std::uint64_t sample) {
  group.on_stage([&source, sample](std::string_view stage) { source.enter(sample, stage); });
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

void send_shares(const SampleGroup& group, std::uint64_t sample, std::span<geometry::Subdomain> parts) {
  const auto& control = group.control();
  for (int rank = 1; rank < group.size(); ++rank) {
    const auto& part = parts[index(rank)];
    ShareHeader header{sample, part.layout.n_global, part.n_tetrahedra_global, part.layout.n_owned, {}};
    std::size_t i = 0;
    for_each_array_of(part, [&](const auto& array) { header.lengths.at(i++) = array.size(); });
    parallel::send_bytes(control, std::as_bytes(std::span(&header, 1)), rank, share_tag);
  }
  parallel::agree(control, [&] { group.computation().enter(sharing_stage); });
  for (int rank = 1; rank < group.size(); ++rank) {
    auto& part = parts[index(rank)];
    for_each_array_of(part,
                      [&](const auto& array) { parallel::send_array(control, array, rank, share_tag); });
    part = {};
  }
}

void send_end(const SampleGroup& group) {
  for (int rank = 1; rank < group.size(); ++rank) parallel::send_bytes(group.control(), {}, rank, share_tag);
}

std::optional<ShareHeader> receive_header(const SampleGroup& group) {
  ShareHeader header;
  if (parallel::receive_length(group.control(), 0, share_tag, sizeof(header)) == 0) return std::nullopt;
  parallel::receive_pieces(group.control(), std::as_writable_bytes(std::span(&header, 1)), 0, share_tag);
  return header;
}

geometry::Subdomain receive_share(const SampleGroup& group, const ShareHeader& header) {
  const auto& control = group.control();
  geometry::Subdomain part;
  part.layout.n_global = header.n_nodes_global;
  part.n_tetrahedra_global = header.n_tetrahedra_global;
  part.layout.n_owned = static_cast<std::int32_t>(header.n_owned);
  parallel::agree(control, [&] {
    group.computation().enter(sharing_stage);
    std::size_t i = 0;
    for_each_array_of(part, [&](auto& array) { array.resize(header.lengths.at(i++)); });
  });
  for_each_array_of(part, [&](auto& array) {
    const auto bytes = std::as_writable_bytes(std::span(array));
    if (parallel::receive_length(control, 0, share_tag, 1) != bytes.size())
      throw std::runtime_error("a part of a sample arrived with an unexpected length");
    parallel::receive_pieces(control, bytes, 0, share_tag);
  });
  return part;
}

PreparedSample prepare(SampleSource& source, std::uint64_t sample) {
  return prepare([&source](std::uint64_t number) { return source.make(number); }, sample);
}

SampleReport report_failure(SampleSteps& steps, std::uint64_t sample, const std::string& reason,
                            double seconds, const PartialSample* partial) {
  SampleReport report;
  report.sample = sample;
  report.seconds = seconds;
  report.summary = steps.failure_row(reason);
  try {
    steps.write_failure(report.summary, partial);
    report.stored = true;
    // A state that led to a failure must not be resumed.
    steps.remove_checkpoint();
  } catch (...) {
    report.summary.error += "; the failure could not be recorded: " + parallel::current_error();
  }
  return report;
}

SampleReport lead_sample(SampleGroup& group, SampleSource& source, const dynamics::SampleControl& control,
                         PreparedSample prepared) {
  const Stopwatch clock;
  const std::uint64_t sample = prepared.sample;
  const auto steps = source.steps(sample);
  if (prepared.failed()) return report_failure(*steps, sample, prepared.error, prepared.seconds);
  const geometry::Realization& realization = prepared.realization;
  dynamics::SampleResult result;
  std::optional<dynamics::SampleResult> partial;
  SampleAnalysis analysis;
  SampleReport report;
  report.sample = sample;
  begin(group, source, sample);
  try {
    auto parts = staged(group, "partition", [&] {
      if (control.log)
        control.log(fmt::format("sample {}: realization made in {:.2f} s, worst quality {:.3f}, {} redrawn",
                                sample, prepared.seconds, realization.report.min_quality,
                                count_text(realization.report.redrawn_points, "point")));
      auto split = steps->split(realization, group.size());
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
      return compute_agreed(
          group, control, [&]() -> SampleSteps& { return *steps; }, parts[0], partial,
          report.checkpoint_error);
    });
    if (result.suspended) {
      report.suspended = true;
      report.seconds = clock.seconds();
      return report;
    }
    result.timings.mesh = prepared.seconds;
    analysis = staged(group, "analysis", [&] {
      if (control.log)
        for (const auto& line : describe(result)) control.log(line);
      return steps->analyse(realization, result);
    });
  } catch (const StepError& failure) {
    if (!partial) return report_failure(*steps, sample, failure.what(), clock.seconds());
    try {
      analysis = steps->analyse(realization, *partial);
    } catch (...) {  // keep mesh, breaks and frames without the analysis
    }
    const PartialSample kept{realization, *partial, analysis};
    return report_failure(*steps, sample, failure.what(), clock.seconds(), &kept);
  }

  report.checkpoint_error.clear();
  report.mesh_attempt = realization.report.attempt;
  report.wave_transit = result.wave_transit;
  report.n_tetrahedra = static_cast<std::int64_t>(realization.tetrahedra.size());
  try {
    staged(group, "writing", [&] { steps->write(realization, result, analysis); });
    report.summary = std::move(analysis.summary);
    report.stored = true;
    steps->remove_checkpoint();
  } catch (const StepError& failure) {
    report.summary = steps->failure_row(failure.what());
  }
  report.seconds = clock.seconds();
  return report;
}

void follow_samples(SampleGroup& group, SampleSource& source, const dynamics::SampleControl& control) {
  while (const auto header = receive_header(group)) {
    begin(group, source, header->sample);
    try {
      const auto part = receive_share(group, *header);
      std::unique_ptr<SampleSteps> steps;
      std::optional<dynamics::SampleResult> partial;
      std::string checkpoint_error;
      const auto make_steps = [&]() -> SampleSteps& { return *(steps = source.steps(header->sample)); };
      compute_agreed(group, control, make_steps, part, partial, checkpoint_error);
    } catch (const parallel::AgreedError&) {
      // The root has the same error and reports it.
    }
  }
}

}  // namespace crackle::ensemble
