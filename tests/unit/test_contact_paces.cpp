// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/contact_paces.h"
#include "parallel/communicator.h"
#include "parallel/node_layout.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

constexpr double spacing = 1e-3;
constexpr double slow = 1e-9;  // in a step [m]
constexpr double fast = 1e-6;
constexpr std::size_t n_nodes = 1000;

class Paces : public testing::Test {
protected:
  Paces() {
    layout.n_global = layout.n_owned = static_cast<std::int32_t>(n_nodes);
    layout.number.resize(n_nodes);
    std::iota(layout.number.begin(), layout.number.end(), std::int64_t{0});
    layout.first_owned = {0, static_cast<std::int64_t>(n_nodes)};
  }

  ContactPaces make() const { return {group, layout, n_nodes}; }

  const parallel::Communicator group{MPI_COMM_SELF};
  parallel::NodeLayout layout;
  std::vector<Vector> movement = std::vector<Vector>(n_nodes, Vector{slow, 0, 0});
};

TEST_F(Paces, OneSplinterSetsTheMarginOfItselfAlone) {
  movement[7] = {0, fast, 0};
  ContactPaces paces = make();
  EXPECT_TRUE(paces.look(movement, true, spacing));
  for (std::size_t n = 0; n < n_nodes; ++n) EXPECT_EQ(paces.is_fast(static_cast<std::int64_t>(n)), n == 7);
  const auto [of_most, of_fast, is_fast] = paces.margins();
  EXPECT_EQ(is_fast[7], 1);
  EXPECT_LT(of_most, 0.2 * of_fast);
  EXPECT_LE(of_fast, 0.5 * spacing);
  EXPECT_EQ(paces.moved(false), 0);
  EXPECT_EQ(paces.moved(true), 0);
}

TEST_F(Paces, PairsLastUntilNodesHaveMovedByHalfAMargin) {
  ContactPaces paces = make();
  ASSERT_TRUE(paces.look(movement, true, spacing));
  const double margin = paces.margins().of_most;
  double moved = 0;
  bool must_search = false;
  for (int k = 0; k < 100000 && !must_search; ++k) {
    EXPECT_LT(2 * moved, margin);
    must_search = paces.look(movement, false, spacing);
    moved += ContactPaces::steps_per_look * slow;
  }
  EXPECT_TRUE(must_search);
  EXPECT_GE(2 * moved, margin * (1 - 1e-9));
}

TEST_F(Paces, NodesMayGetFasterUntilTheNextLook) {
  movement[7] = {0, fast, 0};
  ContactPaces paces = make();
  paces.look(movement, true, spacing);
  // Any of them may be hit by the fastest.
  EXPECT_GE(paces.reach(false), ContactPaces::steps_per_look * fast);
  EXPECT_GE(paces.reach(true), ContactPaces::steps_per_look * fast);
  paces.look(movement, false, spacing);
  EXPECT_NEAR(paces.moved(false), ContactPaces::steps_per_look * slow, 1e-20);
  EXPECT_NEAR(paces.moved(true), ContactPaces::steps_per_look * fast, 1e-17);
  EXPECT_GE(paces.reach(false), paces.moved(false) + ContactPaces::steps_per_look * fast);
}

TEST_F(Paces, WhereManyAreFastTheySetTheMarginOfAll) {
  for (std::size_t n = 0; n < n_nodes / 100; ++n) movement[n] = {0, fast, 0};
  ContactPaces paces = make();
  paces.look(movement, true, spacing);
  EXPECT_FALSE(paces.is_fast(0));
  EXPECT_EQ(paces.margins().of_most, paces.margins().of_fast);
}

TEST_F(Paces, MarginsKeepWithinTheirBounds) {
  for (const double far : {0.0, 1e-15, 1e-9, 1e-6, 1e-3}) {
    movement.assign(n_nodes, Vector{far, 0, 0});
    ContactPaces paces = make();
    paces.look(movement, true, spacing);
    EXPECT_GE(paces.margins().of_most, 0.02 * spacing * (1 - 1e-12)) << far;
    EXPECT_LE(paces.margins().of_most, 0.5 * spacing * (1 + 1e-12)) << far;
  }
}

TEST_F(Paces, ACheckpointHoldsThem) {
  movement[7] = {0, fast, 0};
  ContactPaces paces = make();
  paces.look(movement, true, spacing);
  paces.look(movement, false, spacing);
  ContactPaces again = make();
  again.restore(paces.words(), paces.fast_nodes());
  EXPECT_EQ(again.words(), paces.words());
  EXPECT_TRUE(again.is_fast(7));
  for (int k = 0; k < 1000; ++k) {
    EXPECT_EQ(again.look(movement, false, spacing), paces.look(movement, false, spacing));
    EXPECT_EQ(again.words(), paces.words());
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
