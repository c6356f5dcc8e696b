// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/partition.h"
#include "geometry/point.h"
#include "geometry/subdomain.h"

#include "support/geometry_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <vector>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

std::size_t index(std::int64_t i) {
  return static_cast<std::size_t>(i);
}

const Realization& plate() {
  static const Realization made = [] {
    const Body body = testing::short_plate();
    const MotherPoints base = make_mother_points(body, testing::plate_mesh(), 2012);
    return make_realization(body, base, testing::plate_mesh(), 2012, 0);
  }();
  return made;
}

const Realization& few() {
  static const Realization made = [] {
    const Body body = testing::body({1, 1, 2});
    const input::Mesh mesh = testing::mesh(1, 1);
    return make_realization(body, make_mother_points(body, mesh, 1), mesh, 1, 0);
  }();
  return made;
}

std::int64_t faces_between_parts(const Realization& realization, const Partition& parts) {
  std::map<Triangle, std::vector<std::int32_t>> sides;
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      Triangle face{};
      for (std::size_t k = 0, n = 0; k < 4; ++k)
        if (k != opposite) face[n++] = realization.tetrahedra[i][k];
      std::sort(face.begin(), face.end());
      sides[face].push_back(parts.tetrahedron_part[i]);
    }
  return std::count_if(sides.begin(), sides.end(), [](const auto& side) {
    return side.second.size() == 2 && side.second[0] != side.second[1];
  });
}

TEST(Partition, PartsAreBalancedAndOwnTheirNodes) {
  for (const int n_parts : {1, 2, 3, 4, 7}) {
    const Partition parts = partition(plate(), n_parts);
    EXPECT_EQ(parts.n_parts, n_parts);
    ASSERT_EQ(parts.tetrahedron_part.size(), plate().tetrahedra.size());
    ASSERT_EQ(parts.node_part.size(), plate().nodes.size());
    std::vector<double> tetrahedra(index(n_parts), 0);
    std::vector<double> nodes(index(n_parts), 0);
    std::vector<std::set<std::int32_t>> round_node(plate().nodes.size());
    for (std::size_t i = 0; i < plate().tetrahedra.size(); ++i) {
      ++tetrahedra[index(parts.tetrahedron_part[i])];
      for (const std::int32_t node : plate().tetrahedra[i])
        round_node[index(node)].insert(parts.tetrahedron_part[i]);
    }
    for (std::size_t node = 0; node < plate().nodes.size(); ++node) {
      EXPECT_TRUE(round_node[node].contains(parts.node_part[node]));
      ++nodes[index(parts.node_part[node])];
    }
    const double mean = static_cast<double>(plate().tetrahedra.size()) / n_parts;
    EXPECT_DOUBLE_EQ(parts.imbalance, *std::max_element(tetrahedra.begin(), tetrahedra.end()) / mean);
    EXPECT_LT(parts.imbalance, 1.05);
    EXPECT_GT(*std::min_element(nodes.begin(), nodes.end()), 0);
    EXPECT_EQ(edge_cut(plate(), parts), faces_between_parts(plate(), parts));
    std::printf("%d parts: edge cut %ld, imbalance %.4f\n", n_parts,
                static_cast<long>(edge_cut(plate(), parts)), parts.imbalance);
    EXPECT_LT(edge_cut(plate(), parts), 200 * n_parts);  // cuts across the plate, not along it
    EXPECT_EQ(parts.tetrahedron_part.front(), 0);
  }
}

TEST(Partition, IsTheSameEveryTime) {
  const Partition first = partition(plate(), 4);
  const Partition second = partition(plate(), 4);
  EXPECT_EQ(first.tetrahedron_part, second.tetrahedron_part);
  EXPECT_EQ(first.node_part, second.node_part);
}

TEST(Partition, MorePartsThanTetrahedra) {
  const auto n = static_cast<int>(few().tetrahedra.size());
  for (const int n_parts : {n - 1, n, n + 5}) {
    const Partition parts = partition(few(), n_parts);
    EXPECT_EQ(edge_cut(few(), parts), faces_between_parts(few(), parts));
    for (const std::int32_t part : parts.tetrahedron_part) {
      EXPECT_GE(part, 0);
      EXPECT_LT(part, n_parts);
    }
    EXPECT_EQ(split(few(), parts).size(), index(n_parts));
  }
}

TEST(Partition, RefusesNoParts) {
  EXPECT_THROW(partition(plate(), 0), std::invalid_argument);
}

TEST(Subdomain, OnePartIsTheRealization) {
  const auto parts = split(plate(), partition(plate(), 1));
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].nodes, plate().nodes);
  EXPECT_EQ(parts[0].tetrahedra, plate().tetrahedra);
  EXPECT_EQ(parts[0].layout.n_owned, parts[0].n_local());
  EXPECT_EQ(parts[0].boundary.size(), plate().boundary.size());
  EXPECT_TRUE(parts[0].layout.ghosts.empty());
  EXPECT_EQ(parts[0].layout.first_owned, (std::vector<std::int64_t>{0, parts[0].n_local()}));
}

/// True if a part counts a tetrahedron near a point.
bool counts_near(const Realization& realization, const Subdomain& part, const Point& place, double distance) {
  for (std::size_t i = 0; i < part.tetrahedra.size(); ++i) {
    if (part.owned[i] == 0) continue;
    const auto& t = realization.tetrahedra[index(part.tetrahedron_number[i])];
    if (norm(centroid(realization.nodes, t) - place) < distance) return true;
  }
  return false;
}

void check_split(const Realization& realization, int n_parts, double halo = 0) {
  SCOPED_TRACE(n_parts);
  const Partition parts = partition(realization, n_parts);
  const std::vector<Subdomain> subdomains = split(realization, parts, halo);
  std::vector<int> owners(realization.nodes.size(), 0);
  std::vector<int> counted(realization.tetrahedra.size(), 0);
  std::vector<std::size_t> valence(realization.nodes.size(), 0);
  std::vector<std::size_t> boundary_valence(realization.nodes.size(), 0);
  for (const Tetrahedron& t : realization.tetrahedra)
    for (const std::int32_t node : t) ++valence[index(node)];
  for (const BoundaryTriangle& t : realization.boundary)
    for (const std::int32_t node : t.nodes) ++boundary_valence[index(node)];

  for (std::size_t rank = 0; rank < subdomains.size(); ++rank) {
    const Subdomain& part = subdomains[rank];
    EXPECT_EQ(part.layout.n_global, static_cast<std::int64_t>(realization.nodes.size()));
    EXPECT_EQ(part.n_tetrahedra_global, static_cast<std::int64_t>(realization.tetrahedra.size()));
    ASSERT_EQ(part.layout.number.size(), part.nodes.size());
    ASSERT_EQ(index(part.layout.n_owned) + part.layout.ghosts.size(), part.nodes.size());
    ASSERT_EQ(part.layout.first_owned.size(), subdomains.size() + 1);
    EXPECT_EQ(part.layout.first_owned[rank + 1] - part.layout.first_owned[rank], part.layout.n_owned);
    ASSERT_EQ(part.tetrahedron_number.size(), part.tetrahedra.size());
    ASSERT_EQ(part.owned.size(), part.tetrahedra.size());
    ASSERT_EQ(part.boundary_number.size(), part.boundary.size());
    const auto first_ghost = part.layout.number.begin() + part.layout.n_owned;
    EXPECT_TRUE(std::is_sorted(part.layout.number.begin(), first_ghost));
    EXPECT_TRUE(std::is_sorted(first_ghost, part.layout.number.end()));
    EXPECT_TRUE(std::is_sorted(part.tetrahedron_number.begin(), part.tetrahedron_number.end()));
    EXPECT_TRUE(std::is_sorted(part.boundary_number.begin(), part.boundary_number.end()));

    for (std::size_t i = 0; i < part.nodes.size(); ++i) {
      const std::size_t node = index(part.layout.number[i]);
      EXPECT_EQ(part.nodes[i], realization.nodes[node]);
      const bool owned = i < index(part.layout.n_owned);
      EXPECT_EQ(owned, parts.node_part[node] == static_cast<std::int32_t>(rank));
      if (owned) {
        ++owners[node];
      } else {
        const auto [owner, at_owner] = part.layout.ghosts[i - index(part.layout.n_owned)];
        EXPECT_EQ(owner, parts.node_part[node]);
        EXPECT_LT(at_owner, subdomains[index(owner)].layout.n_owned);
        EXPECT_EQ(subdomains[index(owner)].layout.number[index(at_owner)], part.layout.number[i]);
      }
    }

    std::vector<std::size_t> seen(part.nodes.size(), 0);
    for (std::size_t i = 0; i < part.tetrahedra.size(); ++i) {
      const Tetrahedron& global = realization.tetrahedra[index(part.tetrahedron_number[i])];
      bool touches_owned = false;
      for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_EQ(part.layout.number[index(part.tetrahedra[i][k])], global[k]);
        touches_owned = touches_owned || part.tetrahedra[i][k] < part.layout.n_owned;
        ++seen[index(part.tetrahedra[i][k])];
      }
      if (!touches_owned) {
        EXPECT_TRUE(n_parts > 1 && counts_near(realization, part, centroid(realization.nodes, global),
                                               2 * std::sqrt(3.0) * halo));
      }
      counted[index(part.tetrahedron_number[i])] += part.owned[i];
    }
    std::vector<std::size_t> seen_boundary(part.nodes.size(), 0);
    for (std::size_t i = 0; i < part.boundary.size(); ++i) {
      const BoundaryTriangle& global = realization.boundary[index(part.boundary_number[i])];
      EXPECT_EQ(part.boundary[i].surface, global.surface);
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(part.layout.number[index(part.boundary[i].nodes[k])], global.nodes[k]);
        ++seen_boundary[index(part.boundary[i].nodes[k])];
      }
    }
    for (std::size_t i = 0; i < index(part.layout.n_owned); ++i) {
      EXPECT_EQ(seen[i], valence[index(part.layout.number[i])]);
      EXPECT_EQ(seen_boundary[i], boundary_valence[index(part.layout.number[i])]);
    }
  }
  EXPECT_EQ(subdomains.back().layout.first_owned.back(), static_cast<std::int64_t>(realization.nodes.size()));
  EXPECT_TRUE(std::all_of(owners.begin(), owners.end(), [](int n) { return n == 1; }));
  EXPECT_TRUE(std::all_of(counted.begin(), counted.end(), [](int n) { return n == 1; }));
}

TEST(Subdomain, HasAHaloOfWhatIsNearToItsOwn) {
  const double halo = 1.2e-3;
  for (const int n_parts : {1, 3}) {
    check_split(plate(), n_parts, halo);
    std::size_t n_added = 0;
    for (const Subdomain& part : split(plate(), partition(plate(), n_parts), halo)) {
      for (std::size_t t = 0; t < plate().tetrahedra.size(); ++t) {
        if (part.local_number(static_cast<std::int64_t>(t)) >= 0) continue;
        EXPECT_FALSE(counts_near(plate(), part, centroid(plate().nodes, plate().tetrahedra[t]), halo));
      }
      n_added += part.tetrahedra.size();
    }
    for (const Subdomain& part : split(plate(), partition(plate(), n_parts)))
      n_added -= part.tetrahedra.size();
    std::printf("%d parts: %zu of %zu tetrahedra more in halos\n", n_parts, n_added,
                plate().tetrahedra.size());
    EXPECT_EQ(n_added == 0, n_parts == 1);
  }
}

TEST(Subdomain, EachTetrahedronCountsOnceAndOwnedNodesSeeAllOfTheirs) {
  for (const int n_parts : {1, 2, 3, 4, 7}) check_split(plate(), n_parts);
  for (const int n_parts : {2, 5, 100}) check_split(few(), n_parts);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
