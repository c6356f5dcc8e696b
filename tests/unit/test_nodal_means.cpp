// SPDX-License-Identifier: GPL-3.0-or-later
// Stresses averaged around nodes.
#include "fracture/nodal_means.h"
#include "geometry/partition.h"
#include "geometry/point.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

using mechanics::Symmetric;

constexpr double lower = 10e6, upper = 30e6;  // stresses below and above mid-height [Pa]

/// Eight cells of 1 mm around a node: 24 tetrahedra of equal volume, half of them above it.
class Patch : public testing::Test {
protected:
  static bool is_above(const geometry::Realization& mesh, std::size_t t) {
    return geometry::centroid(mesh.nodes, mesh.tetrahedra[t])[2] > 1e-3;
  }
  Symmetric stress(std::int32_t t) const {
    const double along = is_above(mesh_, index(t)) ? upper : lower;
    return {0, 0, along, 0, 0, along / 2};
  }
  std::int32_t middle_node() const {
    const auto found = std::ranges::find_if(mesh_.nodes, [](const geometry::Point& p) {
      return norm(p - geometry::Point{1e-3, 1e-3, 1e-3}) < 1e-9;
    });
    return static_cast<std::int32_t>(found - mesh_.nodes.begin());
  }
  /// A tetrahedron at the node in the middle, and the corner that it has there.
  std::pair<std::int32_t, std::size_t> at_middle(bool above, int number = 0) const {
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
      const auto& nodes = mesh_.tetrahedra[t];
      const auto corner = std::ranges::find(nodes, middle_node()) - nodes.begin();
      if (corner < 4 && is_above(mesh_, t) == above && number-- == 0)
        return {static_cast<std::int32_t>(t), static_cast<std::size_t>(corner)};
    }
    return {-1, 0};
  }
  /// The mean at the node in the middle for one of its tetrahedra.
  double mean(bool above, int number = 0) {
    const auto subdomain = test::whole(mesh_);
    BreakableBody body(subdomain, test::epoxy());
    for (const auto t : broken_) body.release(t, {}, 0, 0);
    const auto round_node = mechanics::node_tetrahedra(subdomain);
    const NodalMeans means(body, round_node);
    const auto [t, corner] = at_middle(above, number);
    const auto one = means.at(t, corner, [&](std::int32_t other) { return stress(other); });
    const auto all = means.all([&](std::int32_t other) { return stress(other); });
    EXPECT_EQ(one, all[index(means.patch(t, corner))]);
    EXPECT_NEAR(one[5], one[2] / 2, 1e-3);
    return one[2];
  }

  geometry::Realization mesh_ = test::make_box({.size = {2e-3, 2e-3, 2e-3}, .cells = {2, 2, 2}});
  std::vector<std::int32_t> broken_;
};

TEST_F(Patch, OfAStressThatJumpsHasTheMeanOfBothSides) {
  EXPECT_NEAR(mean(true), (lower + upper) / 2, 1);
  EXPECT_NEAR(mean(false), (lower + upper) / 2, 1);
}

TEST_F(Patch, CountsVolumes) {
  for (auto& node : mesh_.nodes)  // three times as much volume above
    if (node[2] > 1.5e-3) node[2] = 4e-3;
  EXPECT_NEAR(mean(true), (lower + 3 * upper) / 4, 1);
}

TEST_F(Patch, EndsWhereAMaterialOrAnInterfaceEnds) {
  for (auto* const numbers : {&mesh_.material, &mesh_.interface}) {
    for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) numbers->push_back(is_above(mesh_, t) ? 1 : 0);
    EXPECT_NEAR(mean(true), upper, 1);
    EXPECT_NEAR(mean(false), lower, 1);
    numbers->clear();
  }
}

TEST_F(Patch, LeavesOutWhatIsBroken) {
  int n_above = 0;
  while (at_middle(true, n_above).first >= 0) ++n_above;
  ASSERT_EQ(n_above, 12);
  broken_.push_back(at_middle(true, 0).first);
  EXPECT_NEAR(mean(false), (12 * lower + 11 * upper) / 23, 1);
  while (std::ssize(broken_) < 12) broken_.push_back(at_middle(true, static_cast<int>(broken_.size())).first);
  EXPECT_NEAR(mean(false), lower, 1);
}

/// The owner of a node holds all that the mean needs, in the same order as one rank.
TEST_F(Patch, HasTheBitsOfTheWholeBodyOnTheRankThatOwnsTheNode) {
  mesh_ = test::make_box({.size = {3e-3, 4e-3, 5e-3}, .cells = {3, 4, 5}, .disturbance = 0.2});
  for (std::size_t t = 0; t < mesh_.tetrahedra.size(); ++t) mesh_.material.push_back(t % 3 == 0 ? 1 : 0);
  const auto stress = [](std::int64_t number) {
    const double s = 1e6 * (20 + static_cast<double>(number * 7919 % 101) / 7);
    return Symmetric{0.2 * s, s, 0.3 * s, 0.1 * s, 0, 0.7 * s};
  };
  const auto whole = test::whole(mesh_);
  const BreakableBody body(whole, test::epoxy());
  const auto round_node = mechanics::node_tetrahedra(whole);
  const NodalMeans means(body, round_node);
  std::int64_t n_known = 0;
  for (const auto& part : geometry::split(mesh_, geometry::partition(mesh_, 3))) {
    const BreakableBody part_body(part, test::epoxy());
    const auto round_part_node = mechanics::node_tetrahedra(part);
    const NodalMeans of_part(part_body, round_part_node);
    for (std::int32_t t = 0; t < part.n_tetrahedra(); ++t)
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const bool is_owned = part.tetrahedra[index(t)][corner] < part.layout.n_owned;
        ASSERT_EQ(of_part.patch(t, corner) >= 0, is_owned);
        if (!is_owned) continue;
        ++n_known;
        ASSERT_EQ(of_part.at(t, corner,
                             [&](std::int32_t one) { return stress(part.tetrahedron_number[index(one)]); }),
                  means.at(static_cast<std::int32_t>(part.tetrahedron_number[index(t)]), corner, stress));
      }
  }
  EXPECT_EQ(n_known, 4 * std::ssize(mesh_.tetrahedra));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
