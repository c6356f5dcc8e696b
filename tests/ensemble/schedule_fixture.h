// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/sample_schedule.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <vector>

/// The scheduler with injected steps whose results are known.
namespace crackle::ensemble {

using analysis::SampleStatus;

/// Records the calls of a rank's steps.
struct Calls {
  std::vector<std::uint64_t> made, computed, written, failures_written;
};

/// Steps with a known result: the onset force is the sum over the nodes of all ranks, 100 sample + 45.
inline SampleSteps make_steps(Calls& calls) {
  SampleSteps steps;
  steps.make = [&](std::uint64_t sample) {
    calls.made.push_back(sample);
    geometry::Realization realization;
    for (int i = 0; i < 10; ++i) realization.nodes.push_back({10.0 * static_cast<double>(sample) + i, 0, 0});
    realization.tetrahedra.resize(3);
    realization.boundary.push_back({{0, 1, 2}, 7});
    realization.report.min_quality = 0.25;
    return realization;
  };
  steps.split = [](std::uint64_t, const geometry::Realization& realization, int n_parts) {
    EXPECT_EQ(realization.tetrahedra.size(), 3u);
    EXPECT_EQ(realization.boundary.at(0).surface, 7);
    EXPECT_EQ(realization.report.min_quality, 0.25);
    std::vector<geometry::Subdomain> parts(static_cast<std::size_t>(n_parts));
    for (std::size_t i = 0; i < realization.nodes.size(); ++i) {
      parts[i % parts.size()].nodes.push_back(realization.nodes[i]);
    }
    return parts;
  };
  steps.compute = [&](const parallel::Communicator& group, std::uint64_t sample,
                      const geometry::Subdomain& subdomain, const dynamics::SampleControl&) {
    calls.computed.push_back(sample);
    double sum = 0;
    for (const auto& node : subdomain.nodes) sum += node[0];
    parallel::check_mpi(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, group.get()),
                        "MPI_Allreduce");
    dynamics::SampleResult result;
    result.onset_force = sum;
    return result;
  };
  steps.analyse = [](std::uint64_t, const geometry::Realization&, const dynamics::SampleResult& result) {
    SampleAnalysis analysis;
    analysis.summary.status = SampleStatus::done;
    analysis.summary.onset_force = result.onset_force;
    return analysis;
  };
  steps.write = [&](std::uint64_t sample, const geometry::Realization&, const dynamics::SampleResult&,
                    const SampleAnalysis&) { calls.written.push_back(sample); };
  steps.write_failure = [&](std::uint64_t sample, const analysis::SampleSummary& failure,
                            const PartialSample*) {
    EXPECT_EQ(failure.status, SampleStatus::failed);
    calls.failures_written.push_back(sample);
  };
  steps.failure_row = [](std::uint64_t, const std::string& reason) {
    analysis::SampleSummary summary;
    summary.status = SampleStatus::failed;
    summary.error = reason;
    return summary;
  };
  return steps;
}

/// The lists of all ranks, sorted, on every rank.
inline std::vector<std::uint64_t> gather(const parallel::Communicator& world,
                                         const std::vector<std::uint64_t>& list) {
  int count = static_cast<int>(list.size());
  std::vector<int> counts(static_cast<std::size_t>(world.size()));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, world.get());
  std::vector<int> starts(counts.size());
  std::exclusive_scan(counts.begin(), counts.end(), starts.begin(), 0);
  std::vector<std::uint64_t> all(static_cast<std::size_t>(starts.back() + counts.back()));
  MPI_Allgatherv(list.data(), count, MPI_UINT64_T, all.data(), counts.data(), starts.data(), MPI_UINT64_T,
                 world.get());
  std::sort(all.begin(), all.end());
  return all;
}

inline std::vector<std::uint64_t> numbers(std::uint64_t n) {
  std::vector<std::uint64_t> list(n);
  std::iota(list.begin(), list.end(), 0);
  return list;
}

class Schedule : public testing::Test {
protected:
  void run(int ranks_per_sample, const std::vector<std::uint64_t>& samples) {
    layout_ = make_group_layout(world_.size(), ranks_per_sample);
    ScheduleEvents events;
    events.started = [&](std::uint64_t sample) { EXPECT_TRUE(started_.insert(sample).second); };
    events.finished = [&](const SampleReport& report) {
      EXPECT_TRUE(reports_.emplace(report.sample, report).second) << "sample " << report.sample;
      ++n_finished_;
    };
    events.tick = [] {};
    schedule_samples(world_, layout_, samples, steps_, events, {.n_realizations = 2}, makers_);
  }

  /// Expects that samples `failing` have failed with `reason`, and that all others of 0..n-1 have the known
  /// result.
  void expect_only_failing(std::uint64_t n, const std::set<std::uint64_t>& failing,
                           const std::string& reason) {
    if (!world_.is_root()) return;
    ASSERT_EQ(reports_.size(), n);
    for (const auto& [sample, report] : reports_) {
      if (failing.contains(sample)) {
        EXPECT_EQ(report.summary.status, SampleStatus::failed) << "sample " << sample;
        EXPECT_THAT(report.summary.error, testing::HasSubstr(reason));
      } else {
        EXPECT_EQ(report.summary.status, SampleStatus::done) << "sample " << sample;
        EXPECT_EQ(report.summary.onset_force, 100.0 * static_cast<double>(sample) + 45);
        EXPECT_EQ(report.n_tetrahedra, 3);
      }
    }
  }

  bool enough_ranks(int ranks_per_sample) const {
    return world_.size() == 1 || world_.size() >= 1 + ranks_per_sample;
  }

  parallel::Communicator world_{MPI_COMM_WORLD};
  GroupLayout layout_;
  input::MeshMakers makers_ = input::MeshMakers::master;
  Calls calls_;
  SampleSteps steps_ = make_steps(calls_);
  std::set<std::uint64_t> started_;
  std::map<std::uint64_t, SampleReport> reports_;
  std::atomic<std::size_t> n_finished_ = 0;  // for steps in other threads
};

}  // namespace crackle::ensemble
