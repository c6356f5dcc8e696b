// SPDX-License-Identifier: GPL-3.0-or-later
// A group of one process in a program that never starts MPI.
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/exact_sum.h"
#include "parallel/ghost_exchange.h"
#include "parallel/sleeping_wait.h"

#include <gmock/gmock.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace crackle::parallel {
namespace CRACKLE_TEST_FILE {

using ::testing::ElementsAre;

class WithoutMpi : public testing::Test {
protected:
  void TearDown() override {
    int is_started = 1;
    MPI_Initialized(&is_started);
    EXPECT_EQ(is_started, 0);
  }
  const Communicator alone_{MPI_COMM_WORLD};
};

TEST_F(WithoutMpi, AProcessIsTheRootOfAGroupOfOne) {
  EXPECT_EQ(alone_.rank(), 0);
  EXPECT_EQ(alone_.size(), 1);
  EXPECT_TRUE(alone_.is_root());
  EXPECT_EQ(Communicator(alone_.get()).size(), 1);
  EXPECT_EQ(Communicator(MPI_COMM_SELF).size(), 1);
}

TEST_F(WithoutMpi, CollectivesReturnWhatTheProcessHas) {
  EXPECT_EQ(share(alone_, 7), 7);
  EXPECT_EQ(share(alone_, std::string("text")), "text");
  EXPECT_EQ(all_reduce(alone_, 2.5, MPI_SUM), 2.5);
  std::vector<std::int64_t> numbers{3, 4};
  all_reduce(alone_, numbers, MPI_MAX);
  EXPECT_THAT(numbers, ElementsAre(3, 4));
  EXPECT_THAT(gather_all<std::int64_t>(alone_, numbers), ElementsAre(3, 4));
  EXPECT_THAT(gather_on_root<std::int64_t>(alone_, numbers), ElementsAre(3, 4));
  EXPECT_THAT(gather_found<int>(alone_, [] { return std::vector{5}; }), ElementsAre(5));
  EXPECT_EQ(largest_of_all(alone_, -1), -1);
  EXPECT_TRUE(any_of_all(alone_, true));
  barrier_asleep(alone_);
}

TEST_F(WithoutMpi, SumsAreThoseOfTheProcess) {
  const std::vector<double> terms{1e300, 1, -1e300};
  EXPECT_EQ(exact_sum(alone_, terms), 1);
  EXPECT_THAT(exact_sums(alone_, std::vector{terms, {2, 3}}), ElementsAre(1, 5));
  EXPECT_EQ(integer_sum(alone_, __int128{1} << 70), 0x1p70);
}

TEST_F(WithoutMpi, FailuresAreAgreedOn) {
  EXPECT_EQ(agree(alone_, [] { return 3; }), 3);
  const auto fail = [] { throw std::runtime_error(std::string(3000, 'x')); };
  for (const auto& work :
       {+[](const Communicator&group, void (*step)()) { agree(group, step); },
        +[](const Communicator&group, void (*step)()) { agree_on_root(group, step); },
        +[](const Communicator&group, void (*step)()) { run_collectively(group, step); }}) {
    try {
      work(alone_, fail);
      ADD_FAILURE();
    } catch (const AgreedError& error) {
      EXPECT_EQ(error.what(), std::string(3000, 'x'));
      EXPECT_EQ(error.failing_rank(), 0);
    }
  }
}

TEST_F(WithoutMpi, ThereAreNoGhosts) {
  const NodeLayout layout{.n_global = 2, .n_owned = 2, .number = {0, 1}, .ghosts = {}, .first_owned = {0, 2}};
  GhostExchange<double> exchange(alone_, layout);
  std::vector<double> values{1, 2};
  exchange.update(values);
  EXPECT_THAT(values, ElementsAre(1, 2));
  EXPECT_TRUE(exchange.sent_nodes().empty());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::parallel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
