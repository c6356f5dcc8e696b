// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays sent in pieces, shares of a group, sleeping waits, failures of the root thrown on all ranks.
#include "common/packing.h"
#include "ensemble/group.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "parallel/message.h"
#include "parallel/sleeping_wait.h"

#include "support/cpu_time.h"
#include "support/group.h"

#include <gmock/gmock.h>

#include <numeric>
#include <stdexcept>
#include <thread>

namespace crackle {
namespace CRACKLE_TEST_FILE {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

TEST(Message, ArraysArriveWholeInPiecesOfAnySize) {
  const parallel::Communicator world(test::group());
  if (world.size() < 2) GTEST_SKIP() << "needs 2 ranks";
  const int last = world.size() - 1;
  for (const std::size_t length : {0, 1, 13, 1000}) {
    for (const std::size_t piece : {7, 8, 1000, 100000}) {
      std::vector<double> values(length);
      std::iota(values.begin(), values.end(), 0.5);
      if (world.is_root()) {
        parallel::send_array(world, values, last, 5, piece);
      } else if (world.rank() == last) {
        EXPECT_EQ(parallel::receive_array<double>(world, 0, 5, piece), values) << length << " in " << piece;
      }
    }
  }
}

TEST(Message, LengthThatIsNoWholeNumberOfElementsIsRefused) {
  const parallel::Communicator world(test::group());
  if (world.size() < 2) GTEST_SKIP() << "needs 2 ranks";
  if (world.is_root()) {
    parallel::send_array(world, std::vector<char>(3), 1, 5);
  } else if (world.rank() == 1) {
    EXPECT_THROW(parallel::receive_array<double>(world, 0, 5), std::runtime_error);
    std::vector<std::byte> rest(3);
    parallel::receive_pieces(world, rest, 0, 5);
  }
}

TEST(Packing, ValuesComeOutAsTheyWentIn) {
  Packer packer;
  packer.put(std::int32_t{-7});
  packer.put(std::string("a reason"));
  packer.put(std::vector<double>{1.5, -2.5});
  packer.put(true);
  Unpacker unpacker(packer.bytes());
  EXPECT_EQ(unpacker.get<std::int32_t>(), -7);
  EXPECT_EQ(unpacker.get<std::string>(), "a reason");
  EXPECT_EQ(unpacker.get<std::vector<double>>(), (std::vector<double>{1.5, -2.5}));
  EXPECT_TRUE(unpacker.get<bool>());
  EXPECT_TRUE(unpacker.empty());
  EXPECT_THROW(unpacker.get<char>(), std::runtime_error);
}

TEST(Packing, LengthBeyondTheEndIsRefused) {
  Packer packer;
  packer.put(std::uint64_t{1} << 62);
  Unpacker unpacker(packer.bytes());
  EXPECT_THROW(unpacker.get<std::vector<double>>(), std::runtime_error);
}

TEST(SampleGroup, SharesArriveWhole) {
  const parallel::Communicator world(test::group());
  ensemble::SampleGroup group(world);
  const auto share_of = [](int rank) {
    geometry::Subdomain subdomain;
    subdomain.layout.n_global = std::int64_t{5'000'000'000} + rank;
    subdomain.n_tetrahedra_global = 7;
    subdomain.layout.n_owned = rank;
    subdomain.nodes = {{0.5, 1.5, rank + 0.25}, {1, 2, 3}};
    subdomain.layout.number = {3, 9};
    subdomain.layout.ghosts = {{rank, 5}};
    subdomain.layout.first_owned = {0, 6, 7};
    subdomain.tetrahedra = {{0, 1, 1, rank}};
    subdomain.tetrahedron_number = {11};
    subdomain.owned = {1};
    subdomain.boundary = {{{0, 1, rank}, 8}};
    subdomain.boundary_number = {4};
    subdomain.material = {2};
    subdomain.map_factor = {0.75F};
    subdomain.interface = {static_cast<std::uint8_t>(rank)};
    return subdomain;
  };
  if (group.is_root()) {
    std::vector<geometry::Subdomain> parts;
    for (int rank = 0; rank < group.size(); ++rank) parts.push_back(share_of(rank));
    ensemble::send_shares(group, 42, parts);
    ensemble::send_end(group);
    return;
  }
  const auto header = ensemble::receive_header(group);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->sample, 42u);
  const auto share = ensemble::receive_share(group, *header);
  const auto expected = share_of(group.control().rank());
  EXPECT_EQ(share.layout.n_global, expected.layout.n_global);
  EXPECT_EQ(share.n_tetrahedra_global, expected.n_tetrahedra_global);
  EXPECT_EQ(share.layout.n_owned, expected.layout.n_owned);
  EXPECT_EQ(share.nodes, expected.nodes);
  EXPECT_EQ(share.layout.number, expected.layout.number);
  ASSERT_EQ(share.layout.ghosts.size(), 1u);
  EXPECT_EQ(share.layout.ghosts[0].rank, group.control().rank());
  EXPECT_EQ(share.layout.ghosts[0].node, 5);
  EXPECT_EQ(share.layout.first_owned, expected.layout.first_owned);
  EXPECT_EQ(share.tetrahedra, expected.tetrahedra);
  EXPECT_EQ(share.tetrahedron_number, expected.tetrahedron_number);
  EXPECT_EQ(share.owned, expected.owned);
  ASSERT_EQ(share.boundary.size(), 1u);
  EXPECT_EQ(share.boundary[0].nodes, expected.boundary[0].nodes);
  EXPECT_EQ(share.boundary[0].surface, 8);
  EXPECT_EQ(share.boundary_number, expected.boundary_number);
  EXPECT_EQ(share.material, expected.material);
  EXPECT_EQ(share.map_factor, expected.map_factor);
  EXPECT_EQ(share.interface, expected.interface);
  EXPECT_FALSE(ensemble::receive_header(group));
}

TEST(SleepingWait, PausesGrowToTheLongest) {
  parallel::BackOff back_off;
  const auto first = back_off.next();
  back_off.sleep();
  EXPECT_GT(back_off.next(), first);
  for (int i = 0; i < 20; ++i) back_off.sleep();
  EXPECT_EQ(back_off.next(), parallel::BackOff::longest);
  EXPECT_LE(parallel::BackOff::longest, 10ms);
  back_off.reset();
  EXPECT_EQ(back_off.next(), first);
}

TEST(SleepingWait, WaitingRanksLeaveTheCore) {
  const parallel::Communicator world(test::group());
  const double before = test::cpu_seconds();
  if (world.rank() == world.size() - 1) std::this_thread::sleep_for(250ms);
  parallel::barrier_asleep(world);
  double used = test::cpu_seconds() - before;
  MPI_Allreduce(MPI_IN_PLACE, &used, 1, MPI_DOUBLE, MPI_MAX, world.get());
  if (world.is_root()) std::printf("a barrier of 0.25 s took %.3f s of CPU time at most\n", used);
  EXPECT_LT(used, 0.05);
}

TEST(Agreement, FailureOfTheRootIsThrownOnAllRanks) {
  const parallel::Communicator world(test::group());
  int n_calls = 0;
  const auto fail = [&] {
    ++n_calls;
    throw std::runtime_error("no folder");
  };
  try {
    parallel::agree_on_root(world, fail);
    FAIL() << "no exception";
  } catch (const parallel::AgreedError& error) {
    EXPECT_STREQ(error.what(), "no folder");
    EXPECT_EQ(error.failing_rank(), 0);
  }
  EXPECT_EQ(n_calls, world.is_root() ? 1 : 0);
  EXPECT_NO_THROW(parallel::agree_on_root(world, [] {}));
}

TEST(Agreement, AnythingThrownIsAgreed) {
  const parallel::Communicator world(test::group());
  const int last = world.size() - 1;
  try {
    parallel::agree(world, [&] {
      if (world.rank() == last) throw 3;
    });
    FAIL() << "no exception";
  } catch (const parallel::AgreedError& error) {
    EXPECT_THAT(error.what(), HasSubstr("unknown"));
    EXPECT_EQ(error.failing_rank(), last);
  }
}

TEST(Agreement, TextOfTheRootIsShared) {
  const parallel::Communicator world(test::group());
  const std::string text = "[ensemble]\nsamples = 3\n";
  EXPECT_EQ(parallel::share(world, world.is_root() ? text : "other"), text);
  EXPECT_EQ(parallel::share(world, std::string(world.is_root() ? "" : "other")), "");
}

TEST(Agreement, TooManyBytesAreRefusedOnAllRanks) {
  const parallel::Communicator world(test::group());
  const std::vector<std::byte> mine(10, std::byte{1});
  const auto n_all = static_cast<std::size_t>(10 * world.size());
  EXPECT_EQ(parallel::gather_bytes_on_root(world, mine, "notes").size(), world.is_root() ? n_all : 0);
  try {
    parallel::gather_bytes_on_root(world, mine, "notes", std::ssize(mine) * world.size() - 1);
    FAIL() << "no exception";
  } catch (const parallel::AgreedError& error) {
    EXPECT_STREQ(error.what(), "notes are too large for one message");
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle
