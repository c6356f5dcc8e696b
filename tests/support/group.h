// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>
#include <mpi.h>

#include <map>
#include <type_traits>
#include <utility>

namespace crackle::test {

/// The ranks that a test runs on. A program started with --groups=1,2,3,4 runs its tests on the first rank,
/// then on the first two, and so on, while the other ranks sleep; without it, on all ranks.
MPI_Comm group();

/// What the running test compares with: the results of its first, second ... call of reference(), each made
/// on the first group that the test runs on and kept for the others. Local; for results that do not depend on
/// the ranks.
template <class Make>
const std::invoke_result_t<Make>& reference(Make make) {
  static std::map<std::pair<const testing::TestInfo*, int>, std::invoke_result_t<Make>> known;
  static std::pair<const testing::TestInfo*, int> test_and_ranks;
  static int n_calls = 0;
  int n_ranks = 0;
  MPI_Comm_size(group(), &n_ranks);
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  if (std::pair now(test, n_ranks); std::exchange(test_and_ranks, now) != now) n_calls = 0;
  const std::pair call(test, n_calls++);
  auto found = known.find(call);
  if (found == known.end()) found = known.emplace(call, make()).first;
  return found->second;
}

}  // namespace crackle::test
