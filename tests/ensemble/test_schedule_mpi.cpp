// SPDX-License-Identifier: GPL-3.0-or-later
// Every sample is handed out once, to whichever group asks, and waiting ranks sleep.
#include "parallel/sleeping_wait.h"
#include "schedule_fixture.h"
#include "support/cpu_time.h"
#include "support/group.h"

#include <chrono>
#include <stdexcept>
#include <thread>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using namespace std::chrono_literals;

TEST_F(Schedule, EverySampleIsComputedOnce) {
  run(1, numbers(23));
  expect_only_failing(23, {}, "");
  EXPECT_EQ(gather(world_, calls_.made), numbers(23));
  EXPECT_EQ(gather(world_, calls_.computed), numbers(23));
  EXPECT_EQ(gather(world_, calls_.written), numbers(23));
  if (world_.is_root()) {
    EXPECT_EQ(events_.samples_started.size(), 23u);
  }
  if (!world_.is_root()) {
    EXPECT_TRUE(calls_.made.empty()) << "only the master makes realizations";
  }
  if (world_.is_root() && world_.size() > 1) {
    EXPECT_TRUE(calls_.computed.empty()) << "the master computes nothing";
  }
}

TEST_F(Schedule, GroupsMakeTheirOwnRealizations) {
  makers_ = input::MeshMakers::groups;
  run(1, numbers(23));
  expect_only_failing(23, {}, "");
  EXPECT_EQ(gather(world_, calls_.made), numbers(23));
  EXPECT_EQ(calls_.made, calls_.computed) << "each group its own";
}

TEST_F(Schedule, AGroupDoesNotWaitForARealization) {
  // The master's first realization is ready only after all other samples have ended: the groups make those.
  makers_ = input::MeshMakers::automatic;
  constexpr std::uint64_t n = 23;
  test_.making = [&](std::uint64_t) {
    const auto start = std::chrono::steady_clock::now();
    while (world_.is_root() && world_.size() > 1 && events_.n_finished + 1 < n) {
      if (std::chrono::steady_clock::now() - start > 15s) throw std::runtime_error("groups are kept waiting");
      std::this_thread::sleep_for(1ms);
    }
  };
  run(1, numbers(n));
  expect_only_failing(n, {}, "");
  EXPECT_EQ(gather(world_, calls_.made), numbers(n));
  EXPECT_EQ(gather(world_, calls_.computed), numbers(n));
  if (world_.size() > 1 && world_.is_root()) {
    EXPECT_LE(calls_.made.size(), 1U) << "none if its thread has not run before";
  }
}

TEST_F(Schedule, TwoRanksShareASampleAndLeftOverRanksStayIdle) {
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

TEST_F(Schedule, MoreGroupsThanSamples) {
  run(1, {5});
  if (world_.is_root()) {
    ASSERT_EQ(reports_.size(), 1u);
    EXPECT_EQ(reports_.at(5).summary.onset_force, 545);
  }
  EXPECT_EQ(gather(world_, calls_.computed), std::vector<std::uint64_t>{5});
}

TEST_F(Schedule, TheMasterHearsWhereTheSampleOfASingleGroupStands) {
  test_.computing = [](const parallel::Communicator& group, std::uint64_t,
                       const dynamics::SampleControl& control) {
    if (control.progress && group.rank() == 0) control.progress("in the middle");
  };
  std::vector<std::string> lines;
  if (world_.is_root()) test_.progress = [&](const std::string& line) { lines.push_back(line); };
  run(std::max(1, world_.size() - 1), numbers(3));
  expect_only_failing(3, {}, "");
  EXPECT_EQ(lines.empty(), !world_.is_root());
  EXPECT_THAT(lines, testing::Each("in the middle"));
  if (world_.size() < 3) return;
  lines.clear();
  forget();
  run(1, numbers(3));
  EXPECT_TRUE(lines.empty()) << "several groups";
}

TEST_F(Schedule, NothingToDo) {
  run(1, {});
  EXPECT_TRUE(reports_.empty());
  EXPECT_TRUE(gather(world_, calls_.computed).empty());
}

TEST_F(Schedule, LongSampleKeepsNoOtherWaiting) {
  if (world_.size() < 3) GTEST_SKIP() << "needs 2 groups";
  // Sample 0 ends only after all others have been computed elsewhere.
  const parallel::Communicator tokens(test::group());
  constexpr std::uint64_t n = 9;
  test_.computing = [&](const auto&, std::uint64_t sample, const auto&) {
    if (sample > 0) {
      for (int rank = 1; rank < tokens.size(); ++rank) {
        if (rank != tokens.rank()) MPI_Send(&sample, 1, MPI_UINT64_T, rank, 0, tokens.get());
      }
      return;
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
  };
  run(1, numbers(n));
  expect_only_failing(n, {}, "");
  const bool had_first = std::count(calls_.computed.begin(), calls_.computed.end(), 0) > 0;
  if (had_first) {
    EXPECT_EQ(calls_.computed.size(), 1u);
  }
}

TEST_F(Schedule, MasterServesWhileItMakesARealization) {
  if (world_.size() < 3) GTEST_SKIP() << "needs 2 groups";
  // The second realization is not ready before the first sample is reported: while one group waits for it,
  // the other's report is received.
  test_.making = [&](std::uint64_t sample) {
    const auto start = std::chrono::steady_clock::now();
    while (sample == 1 && events_.n_finished == 0) {
      if (std::chrono::steady_clock::now() - start > 15s) throw std::runtime_error("no report is taken");
      std::this_thread::sleep_for(1ms);
    }
  };
  run(1, numbers(4));
  expect_only_failing(4, {}, "");
}

TEST_F(Schedule, WhoWaitsSleeps) {
  if (world_.size() == 1) GTEST_SKIP() << "needs 2 ranks";
  test_.computing = [](const auto&, auto, const auto&) { std::this_thread::sleep_for(250ms); };
  const auto start = std::chrono::steady_clock::now();
  const double before = test::cpu_seconds();
  run(1, {0});  // only one of several groups has work
  const double used = test::cpu_seconds() - before;
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("rank %d of %d (%s): %.3f s of CPU time in %.3f s\n", world_.rank(), world_.size(),
              world_.is_root() ? "master" : "worker", used, wall);
  EXPECT_GT(wall, 0.25);
  EXPECT_LT(used, 0.2 * wall);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
