// SPDX-License-Identifier: GPL-3.0-or-later
// The master's queue: order, limits, failures, early end.
#include "ensemble/realization_queue.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
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
