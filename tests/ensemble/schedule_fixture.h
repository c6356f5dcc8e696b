// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ensemble/sample_schedule.h"

#include "support/group.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
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

/// What a test does in the course of a step, by throwing for instance; empty: nothing.
struct Disturbance {
  using Computing = std::function<void(const parallel::Communicator& group, std::uint64_t sample,
                                       const dynamics::SampleControl& control)>;
  std::function<void(std::uint64_t sample)> making, writing, writing_failure;
  std::function<void(std::uint64_t sample, std::vector<geometry::Subdomain>& parts)> split;
  Computing computing, computed;
  /// In place of the computation.
  std::function<dynamics::SampleResult(const parallel::Communicator& group, std::uint64_t sample)> compute;
  std::function<void(const dynamics::SampleResult& result)> analysing;
  dynamics::SampleLog progress;
};

/// Steps with a known result: the onset force is the sum over the nodes of all ranks, 100 sample + 45.
class FakeSteps final : public SampleSteps {
public:
  FakeSteps(std::uint64_t sample, Calls& calls, const Disturbance& test)
      : sample_(sample), calls_(calls), test_(test) {}

  std::vector<geometry::Subdomain> split(const geometry::Realization& realization, int n_parts) override {
    EXPECT_EQ(realization.tetrahedra.size(), 3u);
    EXPECT_EQ(realization.boundary.at(0).surface, 7);
    EXPECT_EQ(realization.material, (std::vector<std::uint8_t>{0, 1, 0}));
    EXPECT_EQ(realization.map_factor, (std::vector<float>{1.5F, 2, 0.25F}));
    EXPECT_EQ(realization.interface, (std::vector<std::uint8_t>{1, 1, 0}));
    EXPECT_EQ(realization.report.min_quality, 0.25);
    std::vector<geometry::Subdomain> parts(static_cast<std::size_t>(n_parts));
    for (std::size_t i = 0; i < realization.nodes.size(); ++i)
      parts[i % parts.size()].nodes.push_back(realization.nodes[i]);
    if (test_.split) test_.split(sample_, parts);
    return parts;
  }
  dynamics::SampleResult compute(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                 dynamics::SampleControl control) override {
    if (test_.compute) return test_.compute(group, sample_);
    if (test_.computing) test_.computing(group, sample_, control);
    calls_.computed.push_back(sample_);
    double sum = 0;
    for (const auto& node : subdomain.nodes) sum += node[0];
    parallel::check_mpi(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, group.get()),
                        "MPI_Allreduce");
    if (test_.computed) test_.computed(group, sample_, control);
    dynamics::SampleResult result;
    result.onset_force = sum;
    return result;
  }
  SampleAnalysis analyse(const geometry::Realization&, const dynamics::SampleResult& result) override {
    if (test_.analysing) test_.analysing(result);
    SampleAnalysis analysis;
    analysis.summary.status = SampleStatus::done;
    analysis.summary.onset_force = result.onset_force;
    return analysis;
  }
  void write(const geometry::Realization&, const dynamics::SampleResult&, const SampleAnalysis&) override {
    if (test_.writing) test_.writing(sample_);
    calls_.written.push_back(sample_);
  }
  void write_failure(const analysis::SampleSummary& failure, const PartialSample*) override {
    if (test_.writing_failure) test_.writing_failure(sample_);
    EXPECT_EQ(failure.status, SampleStatus::failed);
    calls_.failures_written.push_back(sample_);
  }
  analysis::SampleSummary failure_row(const std::string& reason) override {
    analysis::SampleSummary summary;
    summary.status = SampleStatus::failed;
    summary.error = reason;
    return summary;
  }

private:
  std::uint64_t sample_;
  Calls& calls_;
  const Disturbance& test_;
};

class FakeSource final : public SampleSource {
public:
  FakeSource(Calls& calls, const Disturbance& test) : calls_(calls), test_(test) {}

  geometry::Realization make(std::uint64_t sample) override {
    if (test_.making) test_.making(sample);
    calls_.made.push_back(sample);
    geometry::Realization realization;
    for (int i = 0; i < 10; ++i) realization.nodes.push_back({10.0 * static_cast<double>(sample) + i, 0, 0});
    realization.tetrahedra.resize(3);
    realization.boundary.push_back({{0, 1, 2}, 7});
    realization.material = {0, 1, 0};
    realization.map_factor = {1.5F, 2, 0.25F};
    realization.interface = {1, 1, 0};
    realization.report.min_quality = 0.25;
    return realization;
  }
  std::unique_ptr<SampleSteps> steps(std::uint64_t sample) override {
    return std::make_unique<FakeSteps>(sample, calls_, test_);
  }
  dynamics::SampleControl control() override {
    dynamics::SampleControl control;
    control.progress = test_.progress;
    return control;
  }

private:
  Calls& calls_;
  const Disturbance& test_;
};

/// Records what the master hears.
class FakeEvents final : public ScheduleEvents {
public:
  void started(std::uint64_t sample) override { EXPECT_TRUE(samples_started.insert(sample).second); }
  void finished(const SampleReport& report) override {
    EXPECT_TRUE(reports.emplace(report.sample, report).second) << "sample " << report.sample;
    ++n_finished;
  }

  std::set<std::uint64_t> samples_started;
  std::map<std::uint64_t, SampleReport> reports;
  std::atomic<std::size_t> n_finished = 0;  // for steps in other threads
};

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
    FakeSource source(calls_, test_);
    schedule_samples(world_, layout_, samples, source, events_, {.n_realizations = 2}, makers_);
  }

  /// Forgets earlier runs.
  void forget() {
    calls_ = {};
    events_.reports.clear();
    events_.samples_started.clear();
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

  parallel::Communicator world_{test::group()};
  GroupLayout layout_;
  input::MeshMakers makers_ = input::MeshMakers::master;
  Calls calls_;
  Disturbance test_;
  FakeEvents events_;
  std::map<std::uint64_t, SampleReport>& reports_ = events_.reports;
};

}  // namespace crackle::ensemble
