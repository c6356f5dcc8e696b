// SPDX-License-Identifier: GPL-3.0-or-later
// The master's queue: order, limits, failures, early end.
#include "ensemble/realization_queue.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <thread>

namespace crackle::ensemble {
namespace CRACKLE_TEST_FILE {

using namespace std::chrono_literals;

geometry::Realization with_nodes(std::size_t n) {
  geometry::Realization realization;
  realization.nodes.resize(n);
  return realization;
}

PreparedSample take(RealizationQueue& queue) {
  for (;;) {
    if (auto prepared = queue.try_take()) return std::move(*prepared);
    std::this_thread::sleep_for(100us);
  }
}

/// Waits until the count reaches `expected`, and gives it time to exceed that.
void expect_settles(const std::atomic<int>& count, int expected) {
  for (int i = 0; i < 2000 && count < expected; ++i) std::this_thread::sleep_for(1ms);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(count, expected);
}

TEST(RealizationQueue, HandsOutEverySampleOnceInOrder) {
  RealizationQueue queue([](std::uint64_t sample) { return with_nodes(sample); }, {4, 7, 9}, {});
  for (const std::uint64_t expected : {4, 7, 9}) {
    EXPECT_FALSE(queue.exhausted());
    const auto prepared = take(queue);
    EXPECT_EQ(prepared.sample, expected);
    EXPECT_EQ(prepared.realization.nodes.size(), expected);
    EXPECT_FALSE(prepared.failed());
  }
  EXPECT_TRUE(queue.exhausted());
  EXPECT_FALSE(queue.try_take());
}

TEST(RealizationQueue, KeepsNoMoreThanTheLimitAhead) {
  std::atomic<int> n_made = 0;
  RealizationQueue queue(
      [&](std::uint64_t) {
        ++n_made;
        return with_nodes(1);
      },
      std::vector<std::uint64_t>(10), {.n_realizations = 3});
  expect_settles(n_made, 3);
  take(queue);
  expect_settles(n_made, 4);
}

TEST(RealizationQueue, KeepsWithinItsMemory) {
  std::atomic<int> n_made = 0;
  const std::size_t size = 100 * sizeof(geometry::Point);
  RealizationQueue queue(
      [&](std::uint64_t) {
        ++n_made;
        return with_nodes(100);
      },
      std::vector<std::uint64_t>(10), {.n_realizations = 8, .n_bytes = 2 * size + size / 2});
  expect_settles(n_made, 2);
  take(queue);
  expect_settles(n_made, 3);
}

TEST(RealizationQueue, MakesOneAheadHoweverLargeItIs) {
  std::atomic<int> n_made = 0;
  RealizationQueue queue(
      [&](std::uint64_t) {
        ++n_made;
        return with_nodes(100);
      },
      std::vector<std::uint64_t>(10), {.n_realizations = 8, .n_bytes = 1});
  expect_settles(n_made, 1);
  take(queue);
  expect_settles(n_made, 2);
}

/// The most that a master holds while 1,000 groups take realizations as they come, all of them at first and
/// then one after another: those ahead, the one being made, and the one being handed out.
/// @param size of a realization's arrays [byte]; `scale` times as many in the test
double most_held_for_many_groups(double size, double scale) {
  constexpr int n_groups = 1000, n_samples = 2000;
  QueueLimits limits = queue_limits(n_groups);
  limits.n_bytes = static_cast<std::size_t>(scale * static_cast<double>(limits.n_bytes));
  const auto n_nodes = static_cast<std::size_t>(scale * size / sizeof(geometry::Point));
  std::atomic<int> n_begun = 0, n_gone = 0;
  int most = 0;
  RealizationQueue queue(
      [&](std::uint64_t) {
        ++n_begun;
        return with_nodes(n_nodes);
      },
      std::vector<std::uint64_t>(n_samples), limits);
  for (int i = 0; i < n_samples; ++i) {
    // Later groups ask so seldom that the queue fills.
    if (i >= n_groups && i % 100 == 0) std::this_thread::sleep_for(3ms);
    most = std::max(most, n_begun - n_gone);
    const auto prepared = take(queue);
    most = std::max(most, n_begun - n_gone);
    ++n_gone;
  }
  std::printf("%.3g MB each: at most %d held, %.3g GB\n", size / 1e6, most, most * size / 1e9);
  EXPECT_LE(most * size, limits.most_held(scale * size) / scale * 1.01);
  return most * size;
}

TEST(RealizationQueue, HoldsLessThanTwoGigabytesForAThousandGroups) {
  constexpr double of_tetrahedron = 30;
  const double held = most_held_for_many_groups(300e3 * of_tetrahedron, 1e-3);
  EXPECT_LT(held, 1.6e9);
  EXPECT_GT(held, 1e9) << "and makes use of them";
  EXPECT_LE(most_held_for_many_groups(100e6 * of_tetrahedron, 1e-5), 2 * 100e6 * of_tetrahedron)
      << "one ahead, one handed out";
}

TEST(QueueLimits, BoundWhatIsHeld) {
  constexpr QueueLimits limits{.n_realizations = 10, .n_bytes = 1000};
  EXPECT_EQ(limits.most_held(10), 110) << "ten ahead, and the one handed out";
  EXPECT_EQ(limits.most_held(300), 1200) << "three ahead";
  EXPECT_EQ(limits.most_held(5000), 10000) << "one is kept whatever its size";
}

TEST(RealizationQueue, FailureIsHandedOutWithItsReason) {
  RealizationQueue queue(
      [](std::uint64_t sample) {
        if (sample == 1) throw std::runtime_error("no end after 99 rounds");
        if (sample == 2) throw 5;
        return with_nodes(1);
      },
      {0, 1, 2, 3}, {});
  EXPECT_EQ(take(queue).error, "");
  EXPECT_EQ(take(queue).error, "mesh: no end after 99 rounds");
  EXPECT_EQ(take(queue).error, "mesh: unknown exception");
  EXPECT_EQ(take(queue).error, "");
}

TEST(Retries, TakeTheFirstAttemptThatSucceeds) {
  std::vector<int> attempts;
  const auto make = with_retries([&](std::uint64_t sample, int attempt) {
    attempts.push_back(attempt);
    if (attempt < static_cast<int>(sample)) throw std::runtime_error("reason " + std::to_string(attempt));
    auto realization = with_nodes(1);
    realization.report.attempt = attempt;
    return realization;
  });
  EXPECT_EQ(make(0).report.attempt, 0);
  EXPECT_EQ(make(2).report.attempt, 2);
  EXPECT_EQ(attempts, (std::vector{0, 0, 1, 2}));
  const std::string error = prepare(make, 3).error;
  EXPECT_NE(error.find("attempt 1: reason 0; attempt 2: reason 1; attempt 3: reason 2"), std::string::npos)
      << error;
}

TEST(RealizationQueue, EndsBeforeItsSamplesDo) {
  std::atomic<int> n_made = 0;
  {
    RealizationQueue queue(
        [&](std::uint64_t) {
          ++n_made;
          return with_nodes(1);
        },
        std::vector<std::uint64_t>(1000), {.n_realizations = 2});
    expect_settles(n_made, 2);
  }
  EXPECT_EQ(n_made, 2) << "the queue is full";
  {
    RealizationQueue queue(
        [&](std::uint64_t) {
          ++n_made;
          std::this_thread::sleep_for(1ms);
          return with_nodes(1);
        },
        std::vector<std::uint64_t>(1000), {.n_realizations = 1000});
  }
  EXPECT_LT(n_made, 500) << "the queue has room";
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::ensemble
