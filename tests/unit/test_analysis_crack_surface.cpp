// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
#include "cracks/crack_surface.h"
#include "cracks/plane_traces.h"

#include "support/structured_mesh.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using fracture::Break;
using geometry::Point;
using test::StructuredMesh;

geometry::Realization one_tetrahedron(const std::array<Point, 4>& p) {
  geometry::Realization realization;
  realization.nodes.assign(p.begin(), p.end());
  realization.tetrahedra = {{0, 1, 2, 3}};
  return realization;
}

geometry::Body plain_box() {
  return *geometry::make_body(plane::Specimen{{1, 1, 1}, {}});
}

TEST(CrackSurface, RegularTetrahedronHasThreeOrFourEqualFacets) {
  // Edge length 2 sqrt(2); each dual facet has area edge^2 / (12 sqrt(2)) = 8 / (12 sqrt(2)).
  const auto realization = one_tetrahedron({{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}});
  const double expected = 8 / (12 * std::sqrt(2.0));
  for (std::int32_t cut = 0; cut < fracture::n_cuts; ++cut) {
    const std::vector<Break> breaks{{0, 0, 0, 1, 1, cut}};
    const CrackSurface surface = make_crack_surface(plain_box(), realization, breaks, 0);
    ASSERT_EQ(surface.facets.size(), cut < 4 ? 3u : 4u);
    for (const CrackFacet& facet : surface.facets) {
      std::printf("cut %d: area %.12g, expected %.12g\n", cut, facet.area, expected);
      EXPECT_NEAR(facet.area, expected, 1e-14);
      EXPECT_NEAR(local_spacing(facet), 2 * std::sqrt(2.0), 1e-14);
      EXPECT_THAT(facet.corner[2], testing::Each(testing::DoubleNear(0, 1e-15)));
    }
    EXPECT_NEAR(surface.area(), expected * (cut < 4 ? 3 : 4), 1e-13);
    EXPECT_NEAR(surface.cracks.at(0).area, surface.area(), 1e-15);
  }
}

TEST(CrackSurface, EachCutOpensTheFacetsBetweenItsTwoGroups) {
  const std::array<Point, 4> p{{{0, 0, 0}, {12, 0, 0}, {0, 12, 0}, {0, 0, 12}}};
  const auto realization = one_tetrahedron(p);
  // Cut k < 4 separates node k; cuts 4, 5, 6 pair node 0 with 1, 2, 3.
  const std::array<std::set<int>, fracture::n_cuts> first_group{{{0}, {1}, {2}, {3}, {0, 1}, {0, 2}, {0, 3}}};
  for (std::size_t cut = 0; cut < first_group.size(); ++cut) {
    std::set<Point> expected;
    for (int a : first_group[cut]) {
      for (int b = 0; b < 4; ++b) {
        if (first_group[cut].contains(b)) continue;
        Point midpoint{};
        for (std::size_t i = 0; i < 3; ++i) {
          midpoint[i] = (p[index(a)][i] + p[index(b)][i]) / 2;
        }
        expected.insert(midpoint);
      }
    }
    const std::vector<Break> breaks{{0, 0, 0, 1, 1, static_cast<std::int32_t>(cut)}};
    std::set<Point> found;
    for (const CrackFacet& facet : make_crack_surface(plain_box(), realization, breaks, 0).facets) {
      found.insert(facet.corner[0]);
    }
    EXPECT_EQ(found, expected) << "cut " << cut;
  }
}

TEST(CrackSurface, CornersAreEdgeMidpointFaceCentroidsAndCentroid) {
  const auto realization = one_tetrahedron({{{0, 0, 0}, {12, 0, 0}, {0, 12, 0}, {0, 0, 12}}});
  // Cut 5 separates {0, 2} from {1, 3}; its first facet lies between nodes 0 and 1.
  const std::vector<Break> breaks{{0, 0, 0, 1, 1, 5}};
  const CrackSurface surface = make_crack_surface(plain_box(), realization, breaks, 0);
  ASSERT_EQ(surface.facets.size(), 4u);
  const auto& corner = surface.facets[0].corner;
  EXPECT_EQ(corner[0], (Point{6, 0, 0}));
  EXPECT_EQ(corner[1], (Point{4, 4, 0}));
  EXPECT_EQ(corner[2], (Point{3, 3, 3}));
  EXPECT_EQ(corner[3], (Point{4, 0, 4}));
  // Its tetrahedron's opposite edge joins nodes 2 and 3.
  EXPECT_DOUBLE_EQ(local_spacing(surface.facets[0]), 12 * std::sqrt(2.0));
}

TEST(CrackSurface, CutThroughAMeshIsAClosedSheet) {
  const StructuredMesh mesh(plane::Specimen{{3, 4, 5}, {}});
  const auto breaks =
      mesh.break_between([](const Point& p) { return p[2] > 2.5 ? 1 : 0; }, [](const Point&) { return 0.0; });
  const CrackSurface surface = make_crack_surface(mesh.body(), mesh.realization(), breaks, 0);
  EXPECT_EQ(surface.cracks.size(), 1u);
  std::map<std::array<long, 6>, int> facets_at_edge;
  const auto key = [](double x) { return std::lround(x * 12); };
  for (const CrackFacet& facet : surface.facets) {
    for (std::size_t k = 0; k < 4; ++k) {
      Point a = facet.corner[k];
      Point b = facet.corner[(k + 1) % 4];
      if (b < a) std::swap(a, b);
      ++facets_at_edge[{key(a[0]), key(a[1]), key(a[2]), key(b[0]), key(b[1]), key(b[2])}];
    }
  }
  int n_rim = 0;
  for (const auto& [edge, n] : facets_at_edge) {
    const bool on_side = (edge[0] == edge[3] && (edge[0] == 0 || edge[0] == 36)) ||
                         (edge[1] == edge[4] && (edge[1] == 0 || edge[1] == 48));
    EXPECT_EQ(n, on_side ? 1 : 2);
    n_rim += on_side;
  }
  std::printf("%zu facets, %zu edges, %d on the rim\n", surface.facets.size(), facets_at_edge.size(), n_rim);
  EXPECT_GT(n_rim, 0);
}

TEST(CrackSurface, TimesCountFromTheOnsetWithoutLosingDigits) {
  const StructuredMesh mesh(plane::Specimen{{1, 1, 1}, {}});
  const double onset = 76.179191;
  const std::vector<Break> breaks{{0, 75, 3e-6, 1, 1, 0}, {1, onset, 0, 1, 1, 0}, {2, onset, 5e-9, 1, 1, 0}};
  const CrackSurface surface = make_crack_surface(mesh.body(), mesh.realization(), breaks, onset);
  ASSERT_EQ(surface.cracks.size(), 1u);  // tetrahedra of one cube share its diagonal
  EXPECT_DOUBLE_EQ(surface.cracks[0].first_time, 75 - onset + 3e-6);
  EXPECT_EQ(surface.cracks[0].last_time, 5e-9);
  EXPECT_EQ(surface.facets[3].time, 0);

  const CrackSurface static_only = make_crack_surface(
      mesh.body(), mesh.realization(), std::span(breaks).first(2), std::numeric_limits<double>::quiet_NaN());
  EXPECT_DOUBLE_EQ(static_only.cracks[0].first_time, 75 - onset + 3e-6);
  EXPECT_EQ(static_only.cracks[0].last_time, 0);
}

TEST(CrackSurface, RefusesBreaksTheRealizationDoesNotHave) {
  const StructuredMesh mesh(plane::Specimen{{1, 1, 1}, {}});
  for (const Break& wrong : {Break{6, 0, 0, 1, 1, 0}, Break{-1, 0, 0, 1, 1, 0}, Break{0, 0, 0, 1, 1, 7},
                             Break{0, 0, 0, 1, 1, -1}}) {
    EXPECT_THROW(make_crack_surface(mesh.body(), mesh.realization(), {&wrong, 1}, 0), std::invalid_argument);
  }
}

/// Tetrahedra of the notched plate by cube.
class CrackOrigin : public testing::Test {
protected:
  std::int64_t in_cube(int x, int y, int z, std::size_t which = 0) const {
    for (std::size_t t = 0; t < mesh.realization().tetrahedra.size(); ++t) {
      const Point c = mesh.centroid(static_cast<std::int64_t>(t));
      if (c[0] > x && c[0] < x + 1 && c[1] > y && c[1] < y + 1 && c[2] > z && c[2] < z + 1 && which-- == 0) {
        return static_cast<std::int64_t>(t);
      }
    }
    throw std::logic_error("no such cube");
  }
  CrackSurface cracks_of(const std::vector<std::int64_t>& tetrahedra) const {
    std::vector<Break> breaks;
    for (const auto t : tetrahedra) breaks.push_back({t, 0, double(breaks.size()), 1, 1, 0});
    return make_crack_surface(mesh.body(), mesh.realization(), breaks, 0);
  }
  static std::vector<int> notches(const CrackSurface& surface) {
    std::vector<int> result;
    for (const Crack& crack : surface.cracks) result.push_back(crack.start);
    return result;
  }
  /// Crack id of each break.
  static std::vector<int> ids(const CrackSurface& surface) {
    std::vector<int> result;
    for (std::size_t i = 0; i < surface.facets.size(); i += 3) result.push_back(surface.facets[i].crack);
    return result;
  }
  /// All tetrahedra in a row of cubes along y at x = 0.
  std::vector<std::int64_t> row(int y_first, int y_last, int z) const {
    std::vector<std::int64_t> result;
    for (int y = y_first; y != y_last; y += y_first < y_last ? 1 : -1) {
      for (std::size_t k = 0; k < 6; ++k) result.push_back(in_cube(0, y, z, k));
    }
    return result;
  }

  /// True if a tetrahedron shares an edge with one of the others.
  bool touches(std::int64_t tetrahedron, const std::vector<std::int64_t>& others) const {
    const auto& all = mesh.realization().tetrahedra;
    const auto& nodes = all[index(tetrahedron)];
    return std::any_of(others.begin(), others.end(), [&](std::int64_t other) {
      const auto& theirs = all[index(other)];
      return std::count_if(nodes.begin(), nodes.end(), [&](std::int32_t node) {
               return std::find(theirs.begin(), theirs.end(), node) != theirs.end();
             }) >= 2;
    });
  }

  const StructuredMesh mesh{test::notched_plate()};
};

TEST_F(CrackOrigin, BreaksThatShareOnlyANodeAreSeparateCracks) {
  // The tetrahedra of cubes (x, y, z) and (x, y + 1, z + 1) share at least the edge along x between the cubes
  // if they contain it; those of (x, y, z) and (x + 1, y + 1, z + 1) share the corner only.
  const auto touching = cracks_of({in_cube(1, 8, 10), in_cube(2, 9, 11)});
  EXPECT_EQ(notches(touching), (std::vector{-1, -1}));
  const auto same = cracks_of({in_cube(1, 8, 10, 0), in_cube(1, 8, 10, 3)});
  EXPECT_EQ(notches(same), (std::vector{-1}));
}

TEST_F(CrackOrigin, CracksTakeTheNotchTheyTouch) {
  // A tetrahedron at the tip of notch 0, one at notch 1, one in between, one at the mouth of notch 0.
  const auto surface = cracks_of({in_cube(0, 11, 15), in_cube(1, 8, 20), in_cube(0, 4, 8), in_cube(0, 0, 7)});
  EXPECT_EQ(notches(surface), (std::vector{1, -1, 0, -1}));
  EXPECT_EQ(ids(surface), (std::vector{0, 1, 2, 3}));
}

TEST_F(CrackOrigin, ACrackAheadJoinsTheOneThatReachesItAndKeepsTheFirstNumber) {
  auto order = row(8, 9, 8);  // first ahead of notch 0; then a stray one; then from the tip up to it
  order.push_back(in_cube(2, 8, 20));
  const auto rest = row(4, 8, 8);
  order.insert(order.end(), rest.begin(), rest.end());
  const auto surface = cracks_of(order);
  EXPECT_EQ(notches(surface), (std::vector{0, -1}));
  EXPECT_EQ(ids(surface).front(), 0);
  EXPECT_EQ(ids(surface).back(), 0);
  EXPECT_EQ(surface.cracks[0].first_time, 0);
}

TEST_F(CrackOrigin, CracksOfTwoNotchesStayApartAndTheRunningOneTakesTheMeetingPlace) {
  for (const bool upper_runs : {false, true}) {
    // In the plane of notch 1 the cracks would not meet: extend the one of notch 0 towards it.
    std::vector<std::int64_t> lower = row(4, 8, 8);
    for (int z = 9; z < 15; ++z) {
      for (std::size_t k = 0; k < 6; ++k) lower.push_back(in_cube(0, 7, z, k));
    }
    const std::vector<std::int64_t> upper = row(11, 7, 15);
    std::vector<std::int64_t> order = upper_runs ? lower : upper;
    const auto& second = upper_runs ? upper : lower;
    order.insert(order.end(), second.begin(), second.end());
    int n_meeting = 0;
    for (const std::int64_t meeting : row(7, 8, 15)) {
      if (!touches(meeting, lower) || !touches(meeting, upper)) continue;
      ++n_meeting;
      order.push_back(meeting);
      const auto surface = cracks_of(order);
      order.pop_back();
      EXPECT_EQ(notches(surface), upper_runs ? (std::vector{0, 1}) : (std::vector{1, 0}));
      EXPECT_EQ(surface.cracks.at(static_cast<std::size_t>(ids(surface).back())).start, upper_runs ? 1 : 0);
    }
    std::printf("%d tetrahedra touch both cracks\n", n_meeting);
    EXPECT_GT(n_meeting, 0);
  }
}

/// The starts of the notched plate, the second as if it were a hole.
geometry::Complex hole_for_notch(const geometry::Body& plate) {
  geometry::Complex complex;
  complex.crack_starts = plate.crack_starts();
  complex.crack_starts[1].is_hole = true;
  return complex;
}

TEST_F(CrackOrigin, CracksFromAHoleContinueTheOneThatMeetsThemWhicheverCameFirst) {
  const geometry::Body plate(hole_for_notch(mesh.body()));
  for (const bool hole_first : {false, true}) {
    std::vector<std::int64_t> from_notch = row(4, 8, 8);
    for (int z = 9; z < 15; ++z)
      for (std::size_t k = 0; k < 6; ++k) from_notch.push_back(in_cube(0, 7, z, k));
    const auto from_hole = row(11, 7, 15);
    auto order = hole_first ? from_hole : from_notch;
    const auto& second = hole_first ? from_notch : from_hole;
    order.insert(order.end(), second.begin(), second.end());
    for (const std::int64_t meeting : row(7, 8, 15)) order.push_back(meeting);
    order.push_back(in_cube(2, 8, 20));  // apart from both
    std::vector<Break> breaks;
    for (const auto t : order) breaks.push_back({t, 0, double(breaks.size()), 1, 1, 0});
    const CrackSurface surface = make_crack_surface(plate, mesh.realization(), breaks, 0);
    EXPECT_EQ(notches(surface), (std::vector{0, 0, -1}));
    ASSERT_EQ(surface.entries.size(), 1U);
    EXPECT_EQ(surface.entries[0].hole, 1);
    EXPECT_EQ(surface.entries[0].start, 0);
    EXPECT_EQ(surface.entries[0].crack, hole_first ? 1 : 0);
    EXPECT_EQ(surface.cracks[hole_first ? 0 : 1].hole, 1);
    EXPECT_EQ(surface.cracks[hole_first ? 0 : 1].origin(), 1);
    EXPECT_EQ(surface.cracks[hole_first ? 1 : 0].hole, -1);
    EXPECT_EQ(surface.cracks[2].hole, -1);
  }
}

TEST(PlaneTraces, AreTheLinesInWhichCracksCrossPlanes) {
  const auto facet = [](double y, double time, std::int32_t crack) {
    CrackFacet one{};
    one.corner = {{{0, y, 0}, {2, y, 0}, {2, y + 1, 0}, {0, y + 1, 0}}};
    one.time = time;
    one.crack = crack;
    return one;
  };
  CrackSurface surface;
  surface.facets = {facet(0, 3, 1), facet(1, 2, 1), facet(5, 1, 0)};
  surface.cracks.resize(2);
  const std::vector<input::SectionPlane> planes{
      {{0.5, 0, 0}, {2, 0, 0}}, {{0, 0, 1}, {0, 0, 1}}, {{1, 0.5, 7}, {1, 1, 0}}};
  const auto traces = plane_traces(surface, planes);
  ASSERT_EQ(traces.size(), 3U);
  EXPECT_EQ(traces[0].plane, 0);
  EXPECT_EQ(traces[0].crack, 0);
  EXPECT_DOUBLE_EQ(traces[0].length, 1);
  EXPECT_EQ(traces[1].crack, 1);
  EXPECT_DOUBLE_EQ(traces[1].length, 2);
  EXPECT_EQ(traces[1].first_time, 2);
  EXPECT_EQ(traces[1].position, (geometry::Point{0.5, 1, 0}));
  // From (1.5, 0) to (0, 1.5).
  EXPECT_EQ(traces[2].plane, 2);
  EXPECT_DOUBLE_EQ(traces[2].length, 1.5 * std::numbers::sqrt2);
  EXPECT_DOUBLE_EQ(traces[2].position[1], 0.75);

  surface.cracks[0].start = -1;
  surface.cracks[1].start = 1;
  const auto rows = start_traces(surface, planes, 2);  // of start 0, of start 1, of none, of all
  ASSERT_EQ(rows.size(), 12U);
  EXPECT_EQ(rows[0].length, 0);
  EXPECT_TRUE(std::isnan(rows[0].along) && std::isnan(rows[0].time));
  EXPECT_DOUBLE_EQ(rows[1].along, 1);
  EXPECT_DOUBLE_EQ(rows[2].along, 5.5);
  EXPECT_DOUBLE_EQ(rows[3].length, 3);
  EXPECT_DOUBLE_EQ(rows[3].along, 2.5);
  EXPECT_DOUBLE_EQ(rows[3].across, 0);
  EXPECT_EQ(rows[3].time, 1);
  EXPECT_EQ(rows[7].length, 0);
  EXPECT_DOUBLE_EQ(rows[9].along, -7);  // of z
  EXPECT_EQ(rows[9].time, traces[2].first_time);
}

TEST(PlaneTraces, HaveAxesOfTheCoordinatesWhereTheyCan) {
  const auto axes = [](const Vector& normal) { return axes_along({{}, normal}); };
  EXPECT_EQ(axes({0, -2, 0}), (std::array<Vector, 2>{{{1, 0, 0}, {0, 0, 1}}}));
  EXPECT_EQ(axes({0, 3, 4}), (std::array<Vector, 2>{{{1, 0, 0}, {0, -0.8, 0.6}}}));
  for (const Vector& normal : {Vector{1, 2, 3}, {-1, 0, 2}, {3, -1, -1}}) {
    const auto [along, across] = axes(normal);
    EXPECT_NEAR(dot(along, across), 0, 1e-15);
    EXPECT_NEAR(dot(along, normal), 0, 1e-15);
    EXPECT_NEAR(dot(across, normal), 0, 1e-15);
    EXPECT_NEAR(norm(across), 1, 1e-15);
    EXPECT_EQ(along[2], 0);
    EXPECT_GT(across[2], 0);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
