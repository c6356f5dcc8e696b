// SPDX-License-Identifier: GPL-3.0-or-later
// A failure in one sample affects no other, wherever it happens.
#include "parallel/agreement.h"
#include "schedule_fixture.h"

#include <stdexcept>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;

TEST_F(Schedule, SampleThatFailsOnAllRanksFailsAlone) {
  for (const int ranks_per_sample : {1, 2, 3}) {
    if (!enough_ranks(ranks_per_sample)) continue;
    forget();
    test_.computing = [](const auto&, auto sample, const auto&) {
      if (sample == 2) throw parallel::AgreedError(0, "energy blew up");
    };
    run(ranks_per_sample, numbers(6));
    expect_only_failing(6, {2}, "computation: energy blew up");
    EXPECT_EQ(gather(world_, calls_.failures_written), std::vector<std::uint64_t>{2});
  }
}

TEST_F(Schedule, SampleThatFailsOnOneRankFailsAlone) {
  for (const int ranks_per_sample : {1, 2, 3}) {
    for (const bool on_root : {true, false}) {
      if (!enough_ranks(ranks_per_sample)) continue;
      forget();
      test_.computed = [on_root](const auto& group, auto sample, const auto&) {
        if (sample == 1 && group.rank() == (on_root ? 0 : group.size() - 1)) throw std::runtime_error("NaN");
        if (sample == 4 && group.rank() == (on_root ? 0 : group.size() - 1)) throw 7;
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

TEST_F(Schedule, MessagesOfAFailedSampleDoNotReachTheNext) {
  if (world_.size() < 3) GTEST_SKIP() << "needs 3 ranks";
  test_.compute = [](const parallel::Communicator& group, std::uint64_t sample) {
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

TEST_F(Schedule, RealizationThatCannotBeMadeFailsAlone) {
  test_.making = [](std::uint64_t sample) {
    if (sample == 0 || sample == 4 || sample == 5) throw std::runtime_error("redrawing does not end");
  };
  for (const auto makers :
       {input::MeshMakers::master, input::MeshMakers::groups, input::MeshMakers::automatic}) {
    makers_ = makers;
    forget();
    run(1, numbers(6));
    expect_only_failing(6, {0, 4, 5}, "mesh: redrawing does not end");
    EXPECT_EQ(gather(world_, calls_.computed), (std::vector<std::uint64_t>{1, 2, 3}));
    EXPECT_EQ(gather(world_, calls_.failures_written), (std::vector<std::uint64_t>{0, 4, 5}));
  }
}

TEST_F(Schedule, AllRealizationsFail) {
  test_.making = [](std::uint64_t) { throw std::runtime_error("no room"); };
  run(1, numbers(5));
  expect_only_failing(5, {0, 1, 2, 3, 4}, "mesh: no room");
}

TEST_F(Schedule, PartitionAndAnalysisThatFailAreNamed) {
  test_.split = [](std::uint64_t sample, std::vector<geometry::Subdomain>& parts) {
    if (sample == 1) throw std::runtime_error("METIS says no");
    if (sample == 2) parts.resize(9);
  };
  test_.analysing = [](const dynamics::SampleResult& result) {
    if (result.onset_force == 345) throw std::runtime_error("no facets");
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

TEST_F(Schedule, FileThatCannotBeWrittenLeavesNoFile) {
  test_.writing = [](std::uint64_t sample) {
    if (sample == 3) throw std::runtime_error("0003.h5: no space left on device");
  };
  run(1, numbers(6));
  expect_only_failing(6, {3}, "writing: 0003.h5: no space left on device");
  EXPECT_TRUE(gather(world_, calls_.failures_written).empty());
  if (world_.is_root()) {
    EXPECT_FALSE(reports_.at(3).stored);
  }
}

TEST_F(Schedule, FailureThatCannotBeWrittenIsReportedAllTheSame) {
  test_.making = [](std::uint64_t) { throw std::runtime_error("no room"); };
  test_.writing_failure = [](std::uint64_t) { throw std::runtime_error("read-only file system"); };
  run(1, numbers(2));
  expect_only_failing(2, {0, 1}, "mesh: no room; the failure could not be recorded: read-only file system");
  for (const auto& [sample, report] : reports_) EXPECT_FALSE(report.stored) << sample;
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
