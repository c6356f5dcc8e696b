// SPDX-License-Identifier: GPL-3.0-or-later
// The core of the runtime with injected steps: every sample is handed out once, what fails fails alone, and
// who waits sleeps.
#include "crackle/ensemble/hand_out.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/message.h"

#include <gmock/gmock.h>

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>

namespace crackle::ensemble {
namespace {

using namespace std::chrono_literals;
using analysis::SampleStatus;
using testing::HasSubstr;

/// What a rank's steps were called for.
struct Calls {
  std::vector<std::uint64_t> made, computed, written, failures_written;
};

/// Steps with a known answer: the onset force is the sum over the nodes of all ranks, 100 sample + 45.
SampleSteps make_steps(Calls& calls) {
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
  steps.split = [](const geometry::Realization& realization, int n_parts) {
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
                      const geometry::Subdomain& subdomain, const dynamics::SampleLog&) {
    calls.computed.push_back(sample);
    double sum = 0;
    for (const auto& node : subdomain.nodes) sum += node[0];
    parallel::check_mpi(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, group.get()),
                        "MPI_Allreduce");
    dynamics::SampleResult result;
    result.onset_force = sum;
    return result;
  };
  steps.analyse = [](const geometry::Realization&, const dynamics::SampleResult& result) {
    SampleAnalysis analysis;
    analysis.summary.status = SampleStatus::done;
    analysis.summary.onset_force = result.onset_force;
    return analysis;
  };
  steps.write = [&](std::uint64_t sample, const geometry::Realization&, const dynamics::SampleResult&,
                    const SampleAnalysis&) { calls.written.push_back(sample); };
  steps.write_failure = [&](std::uint64_t sample, const analysis::SampleSummary& failure) {
    EXPECT_EQ(failure.status, SampleStatus::failed);
    calls.failures_written.push_back(sample);
  };
  steps.failure_row = [](const std::string& reason) {
    analysis::SampleSummary summary;
    summary.status = SampleStatus::failed;
    summary.error = reason;
    return summary;
  };
  return steps;
}

/// The lists of all ranks, sorted, on every rank.
std::vector<std::uint64_t> gather(const parallel::Communicator& world,
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

std::vector<std::uint64_t> numbers(std::uint64_t n) {
  std::vector<std::uint64_t> list(n);
  std::iota(list.begin(), list.end(), 0);
  return list;
}

class HandOut : public testing::Test {
protected:
  void run(int ranks_per_sample, const std::vector<std::uint64_t>& samples) {
    layout_ = make_group_layout(world_.size(), ranks_per_sample);
    HandOutEvents events;
    events.started = [&](std::uint64_t sample) { EXPECT_TRUE(started_.insert(sample).second); };
    events.finished = [&](const SampleReport& report) {
      EXPECT_TRUE(reports_.emplace(report.sample, report).second) << "sample " << report.sample;
    };
    events.tick = [] {};
    hand_out(world_, layout_, samples, steps_, events, {.n_realizations = 2});
  }

  /// Samples `failing` have failed with `reason`, all others of 0..n-1 have the known answer.
  void expect_only_failing(std::uint64_t n, const std::set<std::uint64_t>& failing,
                           const std::string& reason) {
    if (!world_.is_root()) return;
    ASSERT_EQ(reports_.size(), n);
    for (const auto& [sample, report] : reports_) {
      if (failing.contains(sample)) {
        EXPECT_EQ(report.summary.status, SampleStatus::failed) << "sample " << sample;
        EXPECT_THAT(report.summary.error, HasSubstr(reason));
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
  Calls calls_;
  SampleSteps steps_ = make_steps(calls_);
  std::set<std::uint64_t> started_;
  std::map<std::uint64_t, SampleReport> reports_;
};

TEST_F(HandOut, EverySampleIsComputedOnce) {
  run(1, numbers(23));
  expect_only_failing(23, {}, "");
  EXPECT_EQ(gather(world_, calls_.made), numbers(23));
  EXPECT_EQ(gather(world_, calls_.computed), numbers(23));
  EXPECT_EQ(gather(world_, calls_.written), numbers(23));
  if (world_.is_root()) {
    EXPECT_EQ(started_.size(), 23u);
  }
  if (!world_.is_root()) {
    EXPECT_TRUE(calls_.made.empty()) << "only the master makes realizations";
  }
  if (world_.is_root() && world_.size() > 1) {
    EXPECT_TRUE(calls_.computed.empty()) << "the master computes nothing";
  }
}

TEST_F(HandOut, TwoRanksShareASampleAndLeftOverRanksStayIdle) {
  if (!enough_ranks(2)) GTEST_SKIP() << "needs 3 ranks";
  run(2, numbers(7));
  expect_only_failing(7, {}, "");
  EXPECT_EQ(gather(world_, calls_.written), numbers(7));
  const bool works = layout_.group_of(world_.rank()) >= 0;
  EXPECT_EQ(calls_.computed.size(), works ? 7u : 0u) << "rank " << world_.rank();
  if (world_.size() == 4) {
    EXPECT_EQ(layout_.n_left_over, 1);
  }
}

TEST_F(HandOut, MoreGroupsThanSamples) {
  run(1, {5});
  if (world_.is_root()) {
    ASSERT_EQ(reports_.size(), 1u);
    EXPECT_EQ(reports_.at(5).summary.onset_force, 545);
  }
  EXPECT_EQ(gather(world_, calls_.computed), std::vector<std::uint64_t>{5});
}

TEST_F(HandOut, NothingToDo) {
  run(1, {});
  EXPECT_TRUE(reports_.empty());
  EXPECT_TRUE(gather(world_, calls_.computed).empty());
}

TEST_F(HandOut, SampleThatFailsOnAllRanksFailsAlone) {
  for (const int ranks_per_sample : {1, 2, 3}) {
    if (!enough_ranks(ranks_per_sample)) continue;
    reports_.clear();
    started_.clear();
    calls_ = {};
    auto compute = make_steps(calls_).compute;
    steps_.compute = [compute](const auto& group, auto sample, const auto& subdomain, const auto& log) {
      if (sample == 2) throw parallel::AgreedError(0, "energy blew up");
      return compute(group, sample, subdomain, log);
    };
    run(ranks_per_sample, numbers(6));
    expect_only_failing(6, {2}, "computation: energy blew up");
    EXPECT_EQ(gather(world_, calls_.failures_written), std::vector<std::uint64_t>{2});
  }
}

TEST_F(HandOut, SampleThatFailsOnOneRankFailsAlone) {
  for (const int ranks_per_sample : {1, 2, 3}) {
    for (const bool on_root : {true, false}) {
      if (!enough_ranks(ranks_per_sample)) continue;
      reports_.clear();
      started_.clear();
      auto compute = make_steps(calls_).compute;
      steps_.compute = [compute, on_root](const auto& group, auto sample, const auto& subdomain,
                                          const auto& log) {
        const auto result = compute(group, sample, subdomain, log);
        if (sample == 1 && group.rank() == (on_root ? 0 : group.size() - 1)) throw std::runtime_error("NaN");
        if (sample == 4 && group.rank() == (on_root ? 0 : group.size() - 1)) throw 7;
        return result;
      };
      run(ranks_per_sample, numbers(6));
      expect_only_failing(6, {1, 4}, "computation: ");
      if (world_.is_root()) {
        EXPECT_EQ(reports_.at(1).summary.error, "computation: NaN");
        EXPECT_EQ(reports_.at(4).summary.error, "computation: unknown exception");
      }
    }
  }
}

TEST_F(HandOut, MessagesOfAFailedSampleDoNotReachTheNext) {
  if (world_.size() < 3) GTEST_SKIP() << "needs 3 ranks";
  steps_.compute = [](const parallel::Communicator& group, std::uint64_t sample, const geometry::Subdomain&,
                      const dynamics::SampleLog&) {
    if (group.rank() == 0) {
      MPI_Send(&sample, 1, MPI_UINT64_T, 1, 0, group.get());
      if (sample % 2 == 0) throw std::runtime_error("before the message is received");
    }
    std::uint64_t received = sample;
    if (group.rank() == 1 && sample % 2 == 1) {
      MPI_Recv(&received, 1, MPI_UINT64_T, 0, 0, group.get(), MPI_STATUS_IGNORE);
    }
    if (received != sample) throw std::runtime_error("message of sample " + std::to_string(received));
    dynamics::SampleResult result;
    result.onset_force = 100.0 * static_cast<double>(sample) + 45;
    return result;
  };
  run(2, numbers(6));
  expect_only_failing(6, {0, 2, 4}, "before the message is received");
}

TEST_F(HandOut, RealizationThatCannotBeMadeFailsAlone) {
  auto make = steps_.make;
  steps_.make = [make](std::uint64_t sample) {
    if (sample == 0 || sample == 4 || sample == 5) throw std::runtime_error("redrawing does not end");
    return make(sample);
  };
  run(1, numbers(6));
  expect_only_failing(6, {0, 4, 5}, "mesh: redrawing does not end");
  EXPECT_EQ(gather(world_, calls_.computed), (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(gather(world_, calls_.failures_written), (std::vector<std::uint64_t>{0, 4, 5}));
}

TEST_F(HandOut, AllRealizationsFail) {
  steps_.make = [](std::uint64_t) -> geometry::Realization { throw std::runtime_error("no room"); };
  run(1, numbers(5));
  expect_only_failing(5, {0, 1, 2, 3, 4}, "mesh: no room");
}

TEST_F(HandOut, PartitionAndAnalysisThatFailAreNamed) {
  auto split = steps_.split;
  steps_.split = [split](const geometry::Realization& realization, int n_parts) {
    if (realization.nodes[0][0] == 10) throw std::runtime_error("METIS says no");
    if (realization.nodes[0][0] == 20) return std::vector<geometry::Subdomain>(9);
    return split(realization, n_parts);
  };
  auto analyse = steps_.analyse;
  steps_.analyse = [analyse](const geometry::Realization& realization, const dynamics::SampleResult& result) {
    if (result.onset_force == 345) throw std::runtime_error("no facets");
    return analyse(realization, result);
  };
  const int ranks_per_sample = world_.size() >= 3 ? 2 : 1;
  run(ranks_per_sample, numbers(6));
  expect_only_failing(6, {1, 2, 3}, "");
  if (world_.is_root()) {
    EXPECT_EQ(reports_.at(1).summary.error, "partition: METIS says no");
    EXPECT_THAT(reports_.at(2).summary.error, HasSubstr("partition: 9 parts for"));
    EXPECT_EQ(reports_.at(3).summary.error, "analysis: no facets");
    EXPECT_TRUE(reports_.at(3).stored);
  }
}

TEST_F(HandOut, FileThatCannotBeWrittenLeavesNoFile) {
  auto write = steps_.write;
  steps_.write = [write](std::uint64_t sample, const auto& realization, const auto& result,
                         const auto& analysis) {
    if (sample == 3) throw std::runtime_error("0003.h5: no space left on device");
    write(sample, realization, result, analysis);
  };
  run(1, numbers(6));
  expect_only_failing(6, {3}, "writing: 0003.h5: no space left on device");
  EXPECT_TRUE(gather(world_, calls_.failures_written).empty());
  if (world_.is_root()) {
    EXPECT_FALSE(reports_.at(3).stored);
  }
}

TEST_F(HandOut, FailureThatCannotBeWrittenIsReportedAllTheSame) {
  steps_.make = [](std::uint64_t) -> geometry::Realization { throw std::runtime_error("no room"); };
  steps_.write_failure = [](std::uint64_t, const analysis::SampleSummary&) {
    throw std::runtime_error("read-only file system");
  };
  run(1, numbers(2));
  expect_only_failing(2, {0, 1}, "mesh: no room; this could not be written either: read-only file system");
  for (const auto& [sample, report] : reports_) EXPECT_FALSE(report.stored) << sample;
}

TEST_F(HandOut, LongSampleKeepsNoOtherWaiting) {
  if (world_.size() < 3) GTEST_SKIP() << "needs 2 groups";
  // Sample 0 ends only when all others have been computed, elsewhere.
  const parallel::Communicator tokens(MPI_COMM_WORLD);
  constexpr std::uint64_t n = 9;
  auto compute = steps_.compute;
  steps_.compute = [&](const parallel::Communicator& group, std::uint64_t sample,
                       const geometry::Subdomain& subdomain, const dynamics::SampleLog& log) {
    if (sample > 0) {
      for (int rank = 1; rank < tokens.size(); ++rank) {
        if (rank != tokens.rank()) MPI_Send(&sample, 1, MPI_UINT64_T, rank, 0, tokens.get());
      }
      return compute(group, sample, subdomain, log);
    }
    for (std::uint64_t i = 1; i < n; ++i) {
      const auto start = std::chrono::steady_clock::now();
      while (!parallel::poll_message(tokens, MPI_ANY_SOURCE, 0)) {
        if (std::chrono::steady_clock::now() - start > 15s)
          throw std::runtime_error("others are kept waiting");
        std::this_thread::sleep_for(1ms);
      }
      std::uint64_t other = 0;
      MPI_Recv(&other, 1, MPI_UINT64_T, MPI_ANY_SOURCE, 0, tokens.get(), MPI_STATUS_IGNORE);
    }
    return compute(group, sample, subdomain, log);
  };
  run(1, numbers(n));
  expect_only_failing(n, {}, "");
  const bool had_first = std::count(calls_.computed.begin(), calls_.computed.end(), 0) > 0;
  if (had_first) {
    EXPECT_EQ(calls_.computed.size(), 1u);
  }
}

TEST_F(HandOut, MasterServesWhileItMakesARealization) {
  if (world_.size() < 3) GTEST_SKIP() << "needs 2 groups";
  // The second realization is not ready before the first sample is reported: while one group waits for it,
  // the other one's report is taken.
  std::atomic<bool> reported = false;
  auto make = steps_.make;
  steps_.make = [&](std::uint64_t sample) {
    const auto start = std::chrono::steady_clock::now();
    while (sample == 1 && !reported) {
      if (std::chrono::steady_clock::now() - start > 15s) throw std::runtime_error("no report is taken");
      std::this_thread::sleep_for(1ms);
    }
    return make(sample);
  };
  layout_ = make_group_layout(world_.size(), 1);
  HandOutEvents events;
  events.started = [](std::uint64_t) {};
  events.finished = [&](const SampleReport& report) {
    reported = true;
    reports_.emplace(report.sample, report);
  };
  events.tick = [] {};
  hand_out(world_, layout_, numbers(4), steps_, events, {.n_realizations = 2});
  expect_only_failing(4, {}, "");
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

TEST_F(HandOut, WhoWaitsSleeps) {
  if (world_.size() == 1) GTEST_SKIP() << "needs 2 ranks";
  auto compute = steps_.compute;
  steps_.compute = [compute](const auto& group, auto sample, const auto& subdomain, const auto& log) {
    std::this_thread::sleep_for(1s);
    return compute(group, sample, subdomain, log);
  };
  const auto start = std::chrono::steady_clock::now();
  const double before = cpu_seconds();
  run(1, {0});  // of several groups only one has work
  const double used = cpu_seconds() - before;
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("rank %d of %d (%s): %.3f s of CPU time in %.3f s\n", world_.rank(), world_.size(),
              world_.is_root() ? "master" : "worker", used, wall);
  EXPECT_GT(wall, 1.0);
  EXPECT_LT(used, 0.2 * wall);
}

}  // namespace
}  // namespace crackle::ensemble
