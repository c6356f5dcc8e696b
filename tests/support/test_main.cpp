// SPDX-License-Identifier: GPL-3.0-or-later
// main() of every GoogleTest program: starts MPI and PETSc, and fails on all ranks when one rank fails.
#include "support/group.h"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

MPI_Comm running_group = MPI_COMM_NULL;

/// Names the rank of every failed assertion; on the root GoogleTest's own printer does.
class RankFailures : public testing::EmptyTestEventListener {
public:
  explicit RankFailures(int rank) : rank_(rank) {}

  void OnTestStart(const testing::TestInfo& test) override {
    test_ = std::string(test.test_suite_name()) + "." + test.name();
  }
  void OnTestPartResult(const testing::TestPartResult& part) override {
    if (!part.failed()) return;
    // GoogleTest holds a lock here: to ask it for the current test would wait for ever.
    std::fprintf(stderr, "rank %d: %s: %s:%d\n%s\n", rank_, test_.c_str(),
                 part.file_name() ? part.file_name() : "", part.line_number(), part.message());
  }

private:
  int rank_;
  std::string test_;
};

/// The numbers of ranks of --groups=1,2,3, which is taken out of the arguments; all ranks where it is
/// missing.
std::vector<int> group_sizes(int argc, char** argv, int n_ranks) {
  std::vector<int> sizes;
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], "--groups=", 9) != 0) continue;
    std::istringstream list(argv[i] + 9);
    for (std::string size; std::getline(list, size, ',');) sizes.push_back(std::atoi(size.c_str()));
  }
  if (sizes.empty()) sizes.push_back(n_ranks);
  return sizes;
}

/// A barrier in which waiting ranks sleep, as MPI's own would take the cores of those that work.
void wait_for_all() {
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(MPI_COMM_WORLD, &request);
  for (int is_done = 0; is_done == 0;) {
    MPI_Test(&request, &is_done, MPI_STATUS_IGNORE);
    if (is_done == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

/// Runs the tests on the first ranks.
/// @return 0 if none failed on this rank
int run_tests_on(int n_ranks, int rank) {
  int failed = 0;
  MPI_Comm_split(MPI_COMM_WORLD, rank < n_ranks ? 0 : MPI_UNDEFINED, rank, &running_group);
  if (running_group != MPI_COMM_NULL) {
    failed = RUN_ALL_TESTS();
    MPI_Comm_free(&running_group);
  }
  wait_for_all();
  return failed;
}

}  // namespace

MPI_Comm crackle::test::group() {
  return running_group;
}

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (PetscInitializeNoArguments() != 0) return EXIT_FAILURE;
  int rank = 0, n_ranks = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
  if (rank != 0) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new RankFailures(rank));
  }
  int failed = 0;
  for (const int size : group_sizes(argc, argv, n_ranks)) {
    if (size < 1 || size > n_ranks) {
      if (rank == 0) std::fprintf(stderr, "--groups: there are %d ranks, not %d\n", n_ranks, size);
      failed = 1;
      continue;
    }
    if (rank == 0 && n_ranks > 1) std::printf("\non %d of %d ranks\n", size, n_ranks);
    failed |= run_tests_on(size, rank);
  }
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  if (PetscFinalize() != 0) return EXIT_FAILURE;
  return failed;
}
