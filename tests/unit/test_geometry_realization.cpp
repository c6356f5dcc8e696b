// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/random.h"
#include "geometry/quality.h"
#include "geometry/realization.h"
#include "geometry/symmetry.h"

#include "support/effort.h"
#include "support/geometry_bodies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using plane::Face;
using testing::body;
using testing::mesh;
using testing::mm;
using testing::notch;

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

struct Case {
  const char* name;
  Body body;
  input::Mesh mesh;
};

std::vector<Case> cases() {
  std::vector<Case> list;
  list.push_back({"no notch", body({3, 4, 5}), mesh(0.6, 0.6)});
  list.push_back({"one coarse cell", body({1, 1, 1}), mesh(5, 5)});
  list.push_back({"thin sheet", body({0.2, 8, 9}), mesh(1, 1)});
  list.push_back({"one notch", body({2, 10, 12}, {notch(Face::y_min, 6, 4, 0.5)}), mesh(1.2, 0.25)});
  list.push_back(
      {"one cell over the height", body({2, 10, 12}, {notch(Face::y_min, 6, 4, 0.6)}), mesh(1.5, 0.6)});
  list.push_back({"two anti-symmetric", testing::short_plate(), testing::plate_mesh()});
  list.push_back({"four faces", testing::four_notches(), mesh(1, 0.3)});
  list.push_back({"thin and deep", body({1, 6, 8}, {notch(Face::z_max, 3, 5, 0.1)}), mesh(1, 0.3, 0.3)});
  list.push_back({"wide", body({2, 10, 12}, {notch(Face::y_max, 6, 2, 6)}), mesh(1, 0.4)});
  list.push_back({"narrow ligament",
                  body({1, 6, 8}, {notch(Face::y_min, 4, 3, 0.5), notch(Face::y_max, 4.2, 2.8, 0.5)}),
                  mesh(1, 0.25)});
  list.push_back({"regions, one to the face and one inside", testing::short_plate(), mesh(1.5, 0.3, 0.3)});
  list.back().mesh.regions = {testing::region({plane::unbounded, {0, 16}, {10, 14}}, 0.4),
                              testing::region({{{1, 2}, {5, 8}, {18, 22}}}, 0.25)};
  return list;
}

// Realizations are verified when they are made; this verifies them again, by other means if possible.
TEST(Realization, ConformsToTheBody) {
  for (const Case& each : cases()) {
    SCOPED_TRACE(each.name);
    const MotherPoints base = make_mother_points(each.body, each.mesh, 2012);
    const auto n_samples = static_cast<std::uint64_t>(test::repetitions(1, 3));
    for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
      const Realization made = make_realization(each.body, base, each.mesh, 2012, sample);
      EXPECT_NO_THROW(verify(made, each.body, each.mesh.min_quality));
      double volume = 0;
      double worst = 1;
      for (const Tetrahedron& t : made.tetrahedra) {
        const auto node = [&](std::size_t i) { return made.nodes[index(t[i])]; };
        volume += signed_volume(node(0), node(1), node(2), node(3));
        worst = std::min(worst, mean_ratio(node(0), node(1), node(2), node(3)));
        Point centre{};
        for (std::size_t k = 0; k < 4; ++k)
          for (std::size_t i = 0; i < 3; ++i) centre[i] += node(k)[i] / 4;
        EXPECT_TRUE(each.body.contains(centre));
      }
      EXPECT_NEAR(volume / each.body.volume(), 1, 1e-12);
      EXPECT_NEAR(worst, made.report.min_quality, 1e-12);
      EXPECT_GE(worst, 0.2 * (1 - 1e-12));
      if (sample == 0)
        std::printf(
            "%-26s %6zu nodes %7zu tetrahedra, volume off by %8.1e, quality >= %.4f, %ld redrawn in %d "
            "rounds\n",
            each.name, made.nodes.size(), made.tetrahedra.size(), volume / each.body.volume() - 1, worst,
            static_cast<long>(made.report.redrawn_points), made.report.rounds);
    }
  }
}

class PlateRealization : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
    base_ = new MotherPoints(make_mother_points(testing::short_plate(), testing::plate_mesh(), 2012));
  }
  static void TearDownTestSuite() { delete base_; }
  Realization make(std::uint64_t seed, std::uint64_t sample, double perturbation = 0.2) const {
    input::Mesh parameters = testing::plate_mesh();
    parameters.perturbation = perturbation;
    return make_realization(plate, *base_, parameters, seed, sample);
  }
  const MotherPoints& base() const { return *base_; }
  const Body plate = testing::short_plate();

private:
  static inline MotherPoints* base_ = nullptr;
};

bool same(const Realization& a, const Realization& b) {
  return a.nodes == b.nodes && a.tetrahedra == b.tetrahedra &&
         std::equal(a.boundary.begin(), a.boundary.end(), b.boundary.begin(), b.boundary.end(),
                    [](const BoundaryTriangle& s, const BoundaryTriangle& t) {
                      return s.nodes == t.nodes && s.surface == t.surface;
                    }) &&
         a.report.rounds == b.report.rounds && a.report.redrawn_points == b.report.redrawn_points;
}

TEST_F(PlateRealization, IsAFunctionOfSeedAndSample) {
  const Realization first = make(2012, 3);
  make(2012, 4);
  EXPECT_TRUE(same(first, make(2012, 3)));
  EXPECT_FALSE(same(first, make(2012, 4)));
  EXPECT_FALSE(same(first, make(2013, 3)));
}

TEST_F(PlateRealization, TopologyDiffersBetweenSamples) {
  const Realization a = make(2012, 0);
  const Realization b = make(2012, 1);
  std::vector<Tetrahedron> common;
  const auto sorted = [](std::vector<Tetrahedron> list) {
    for (Tetrahedron& t : list) std::sort(t.begin(), t.end());
    return list;
  };
  const auto first = sorted(a.tetrahedra);
  const auto second = sorted(b.tetrahedra);
  std::set_intersection(first.begin(), first.end(), second.begin(), second.end(), std::back_inserter(common));
  const double share = static_cast<double>(common.size()) / static_cast<double>(first.size());
  std::printf("%.3f of the tetrahedra are in both samples\n", share);
  EXPECT_LT(share, 0.8);
}

TEST_F(PlateRealization, WithoutPerturbationIsTheBase) {
  const Realization made = make(2012, 5, 0);
  EXPECT_EQ(made.nodes, base().position);
  EXPECT_EQ(made.report.redrawn_points, 0);
  EXPECT_GE(made.report.min_quality, 0.4);
}

TEST_F(PlateRealization, NodesKeepToTheirSurfacesAndTheirBall) {
  for (const double amplitude : {0.05, 0.2, 0.35}) {
    const Realization made = make(7, 1, amplitude);
    const Symmetry symmetry = symmetry_of(plate, made.report.symmetry);
    double farthest = 0;
    for (std::size_t i = 0; i < base().size(); ++i) {
      double squared = 0;
      const Point node = symmetry.preimage(made.nodes[i]);
      for (unsigned axis = 0; axis < 3; ++axis) {
        const double shift = node[axis] - base().position[i][axis];
        const bool held = !((base().movable[i] >> axis) & 1u);
        EXPECT_TRUE(!held || shift == 0);
        squared += shift * shift;
      }
      farthest = std::max(farthest, std::sqrt(squared) / base().spacing[i]);
      EXPECT_EQ(plate.movable(made.nodes[i]), base().movable[i]);
    }
    std::printf("amplitude %.2f: largest displacement %.4f spacings\n", amplitude, farthest);
    EXPECT_LE(farthest, amplitude * (1 + 1e-12));
    EXPECT_GT(farthest, 0.98 * amplitude);
  }
}

TEST_F(PlateRealization, IsNumberedCanonically) {
  const Realization made = make(2012, 0);
  Tetrahedron before{-1, -1, -1, -1};
  for (const Tetrahedron& t : made.tetrahedra) {
    EXPECT_EQ(t[0], *std::min_element(t.begin(), t.end()));
    EXPECT_EQ(t[1], *std::min_element(t.begin() + 1, t.end()));
    EXPECT_GT(signed_volume(made.nodes[index(t[0])], made.nodes[index(t[1])], made.nodes[index(t[2])],
                            made.nodes[index(t[3])]),
              0);
    Tetrahedron sorted = t;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_LT(before, sorted);
    before = sorted;
  }
  EXPECT_TRUE(std::is_sorted(made.boundary.begin(), made.boundary.end(),
                             [](const auto& a, const auto& b) { return a.nodes < b.nodes; }));
}

// The same tessellation with another orientation in the body, so that features of the base at one notch occur
// equally often at the other.
TEST_F(PlateRealization, IsSetIntoTheBodyInEachWayThatFits) {
  input::Mesh as_it_lies = testing::plate_mesh();
  as_it_lies.symmetry = input::MeshSymmetry::none;
  std::map<std::uint8_t, int> count;
  for (std::uint64_t sample = 0; sample < 12; ++sample) {
    const Realization made = make(2012, sample);
    const Realization base_frame = make_realization(plate, base(), as_it_lies, 2012, sample);
    ++count[made.report.symmetry];
    EXPECT_EQ(base_frame.report.symmetry, 0);
    ASSERT_EQ(made.nodes.size(), base_frame.nodes.size());
    const Symmetry symmetry = symmetry_of(plate, made.report.symmetry);
    for (std::size_t i = 0; i < made.nodes.size(); ++i)
      ASSERT_EQ(made.nodes[i], symmetry.image(base_frame.nodes[i]));
    const auto corners = [](const Realization& realization) {
      std::vector<Tetrahedron> list = realization.tetrahedra;
      for (Tetrahedron& t : list) std::sort(t.begin(), t.end());
      return list;
    };
    EXPECT_EQ(corners(made), corners(base_frame));
    EXPECT_NO_THROW(verify(made, plate, 0.2));
  }
  for (const std::uint8_t axes : {0, 1, 6, 7}) EXPECT_GE(count[axes], 1) << int{axes};
  EXPECT_EQ(count.size(), 4u);
  EXPECT_EQ(make(2012, 1, 0).report.symmetry, 0) << "nothing is disturbed without a perturbation";
}

std::vector<std::uint8_t> codes(const std::vector<Symmetry>& symmetries) {
  std::vector<std::uint8_t> result;
  for (const Symmetry& symmetry : symmetries) result.push_back(symmetry.code);
  return result;
}

TEST(Symmetry, IsThatOfTheNotches) {
  using testing::notch;
  using List = std::vector<std::uint8_t>;
  EXPECT_EQ(codes(testing::body({1, 2, 3}).symmetries()), (List{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(codes(testing::short_plate().symmetries()), (List{0, 1, 6, 7}));
  EXPECT_EQ(codes(testing::four_notches().symmetries()), (List{0, 1}));
  const auto plate_with = [](std::vector<plane::Notch> notches) {
    return testing::body({5, 24.5, 140}, std::move(notches));
  };
  const plane::Notch lower = notch(plane::Face::y_min, 67.3, 5.5, 0.6);
  EXPECT_EQ(codes(plate_with({lower, notch(plane::Face::y_max, 72.7, 5.5, 0.6)}).symmetries()),
            (List{0, 1, 6, 7}));
  EXPECT_EQ(codes(plate_with({lower, notch(plane::Face::y_max, 72.7, 5.4, 0.6)}).symmetries()), (List{0, 1}));
  EXPECT_EQ(codes(plate_with({lower, notch(plane::Face::y_max, 67.3, 5.5, 0.6)}).symmetries()),
            (List{0, 1, 2, 3}));
  EXPECT_EQ(codes(plate_with({lower, notch(plane::Face::y_min, 72.7, 5.5, 0.6)}).symmetries()),
            (List{0, 1, 4, 5}));
  EXPECT_EQ(codes(plate_with({notch(plane::Face::y_min, 70, 5.5, 0.6)}).symmetries()), (List{0, 1, 4, 5}));
}

TEST(Symmetry, OfAMeshIsThatOfItsRegionsToo) {
  using List = std::vector<std::uint8_t>;
  const Body plate = testing::body({5, 24.5, 140}, {testing::notch(plane::Face::y_min, 67.3, 5.5, 0.6),
                                                    testing::notch(plane::Face::y_max, 72.7, 5.5, 0.6)});
  input::Mesh mesh = testing::mesh(1, 0.3);
  const auto with = [&](std::vector<input::MeshRegion> regions) {
    mesh.regions = std::move(regions);
    return codes(symmetries(plate, mesh));
  };
  const plane::Region corridor{plane::unbounded, plane::unbounded, {60.1, 79.9}};
  EXPECT_EQ(with({}), (List{0, 1, 6, 7}));
  EXPECT_EQ(with({testing::region(corridor, 0.3)}), (List{0, 1, 6, 7}));
  EXPECT_EQ(with({testing::region({plane::unbounded, plane::unbounded, {60, 81}}, 0.3)}), (List{0, 1}));
  EXPECT_EQ(with({testing::region({{{0, 1}, plane::unbounded, {60.1, 79.9}}}, 0.3)}), (List{0, 6}));
  const plane::Region low{plane::unbounded, {0, 10}, {60, 80}}, high{plane::unbounded, {14.5, 90}, {60, 80}};
  EXPECT_EQ(with({testing::region(low, 0.3), testing::region(high, 0.3)}), (List{0, 1, 6, 7}));
  EXPECT_EQ(with({testing::region(low, 0.3), testing::region(high, 0.4)}), (List{0, 1}));

  // Thus a sample's refined mesh regions always stay in place.
  const Body small = testing::short_plate();
  input::Mesh fine = testing::mesh(1.5, 0.5, 0.3);
  fine.regions = {testing::region({plane::unbounded, plane::unbounded, {18, 24}}, 0.5)};
  const MotherPoints base = make_mother_points(small, fine, 1);
  for (std::uint64_t sample = 0; sample < 12; ++sample) {
    const Realization made = make_realization(small, base, fine, 1, sample);
    EXPECT_EQ(made.report.symmetry & 6u, 0u);
  }
}

TEST(Symmetry, MapsCrackStarts) {
  const Body plate = testing::short_plate();
  const std::vector<Symmetry> all = plate.symmetries();
  EXPECT_EQ(all[1].crack_start, (std::vector<std::int32_t>{0, 1}));
  EXPECT_EQ(all[2].crack_start, (std::vector<std::int32_t>{1, 0}));
  EXPECT_EQ(all[2].name, "reflected in the middle of y and z");
  EXPECT_FALSE(all[2].is_reflection);
  EXPECT_TRUE(all[3].is_reflection);
  EXPECT_EQ(all[2].image(plate.crack_starts()[0].tip), plate.crack_starts()[1].tip);
  EXPECT_EQ(symmetry_of(plate, 6).name, all[2].name);
  EXPECT_THROW(symmetry_of(plate, 2), std::invalid_argument);
}

// Walls whose coordinates are not exact in binary: points on a wall stay exactly on its image.
TEST(Symmetry, MapsPlanesExactly) {
  const Body plate = testing::body({5, 24.5, 140}, {testing::notch(plane::Face::y_min, 67.3, 5.3, 0.7),
                                                    testing::notch(plane::Face::y_max, 72.7, 5.3, 0.7)});
  for (const Symmetry& symmetry : plate.symmetries())
    for (const Point& corner : plate.corners()) {
      const Point q = symmetry.image(corner);
      EXPECT_TRUE(plate.contains(q));
      EXPECT_EQ(plate.movable(q), plate.movable(corner));
      EXPECT_EQ(symmetry.preimage(q), corner);
    }
}

/// Positive if e lies inside the circumsphere of a positive tetrahedron, relative to its size.
double in_sphere(const std::array<Point, 4>& corner, const Point& e) {
  std::array<std::array<long double, 4>, 4> m{};
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      m[k][i] = static_cast<long double>(corner[k][i]) - e[i];
      m[k][3] += m[k][i] * m[k][i];
    }
  }
  const auto minor = [&](std::size_t a, std::size_t b, std::size_t c) {
    return m[a][0] * (m[b][1] * m[c][2] - m[b][2] * m[c][1]) -
           m[a][1] * (m[b][0] * m[c][2] - m[b][2] * m[c][0]) +
           m[a][2] * (m[b][0] * m[c][1] - m[b][1] * m[c][0]);
  };
  const long double determinant = m[0][3] * minor(1, 2, 3) - m[1][3] * minor(0, 2, 3) +
                                  m[2][3] * minor(0, 1, 3) - m[3][3] * minor(0, 1, 2);
  const double size = std::pow(6 * signed_volume(corner[0], corner[1], corner[2], corner[3]), 5.0 / 3);
  return static_cast<double>(determinant) / size;
}

// Local redrawing changes the tessellation locally; the result must still be Delaunay.
TEST_F(PlateRealization, IsDelaunay) {
  const Realization made = make(2012, 2, 0.35);
  EXPECT_GT(made.report.redrawn_points, 10);
  struct Side {
    std::array<Point, 4> corner;
    Point opposite;
  };
  std::map<Triangle, std::vector<Side>> sides;
  for (const Tetrahedron& t : made.tetrahedra) {
    const std::array<Point, 4> corner{made.nodes[index(t[0])], made.nodes[index(t[1])],
                                      made.nodes[index(t[2])], made.nodes[index(t[3])]};
    for (std::size_t k = 0; k < 4; ++k) {
      Triangle face{};
      for (std::size_t i = 0, n = 0; i < 4; ++i)
        if (i != k) face[n++] = t[i];
      std::sort(face.begin(), face.end());
      sides[face].push_back({corner, corner[k]});
    }
  }
  double deepest = -1e300;
  for (const auto& [face, both] : sides)
    if (both.size() == 2) deepest = std::max(deepest, in_sphere(both[0].corner, both[1].opposite));
  std::printf("deepest intrusion into a circumsphere: %.2e\n", deepest);
  EXPECT_LE(deepest, 1e-9);
  // The measure detects an intrusion: the centroid of a tetrahedron lies inside its circumsphere.
  const auto& [corner, opposite] = sides.begin()->second[0];
  Point centre{};
  for (const Point& p : corner)
    for (std::size_t i = 0; i < 3; ++i) centre[i] += p[i] / 4;
  EXPECT_GT(in_sphere(corner, centre), 1e-3);
}

// After redrawing: zero mean and the covariance of a uniform ball, amplitude^2 / 5, without a preferred
// direction.
TEST_F(PlateRealization, DisplacementsAreUnbiased) {
  constexpr int n_samples = 40;
  std::array<double, 3> mean{};
  std::array<std::array<double, 3>, 3> covariance{};
  double n = 0;
  double n_fine = 0;
  double square_where_fine = 0;
  const double fine = 1.2 * std::ranges::min(base().spacing);
  double redrawn = 0;
  for (int sample = 0; sample < n_samples; ++sample) {
    const Realization made = make(11, static_cast<std::uint64_t>(sample));
    const Symmetry symmetry = symmetry_of(plate, made.report.symmetry);
    redrawn += static_cast<double>(made.report.redrawn_points);
    for (std::size_t k = 0; k < base().size(); ++k) {
      if (base().movable[k] != 7) continue;
      ++n;
      const Point node = symmetry.preimage(made.nodes[k]);
      n_fine += base().spacing[k] < fine ? 1 : 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const double shift_i = (node[i] - base().position[k][i]) / (0.2 * base().spacing[k]);
        mean[i] += shift_i;
        if (base().spacing[k] < fine) square_where_fine += shift_i * shift_i;
        for (std::size_t j = 0; j < 3; ++j)
          covariance[i][j] += shift_i * (node[j] - base().position[k][j]) / (0.2 * base().spacing[k]);
      }
    }
  }
  const double share = redrawn / n_samples / static_cast<double>(base().size());
  std::printf("%.0f displacements, %.2f %% redrawn; mean %.4f %.4f %.4f\n", n, 100 * share, mean[0] / n,
              mean[1] / n, mean[2] / n);
  EXPECT_LT(share, 0.02);
  std::printf("%.0f displacements where the mesh is finest: variance %.4f\n", n_fine,
              square_where_fine / (3 * n_fine));
  EXPECT_NEAR(square_where_fine / (3 * n_fine), 0.2, 0.2 * 2 / std::sqrt(n_fine));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean[i] / n, 0, 4 * std::sqrt(0.2 / n));
    for (std::size_t j = 0; j < 3; ++j) {
      std::printf("covariance %zu %zu: %.4f\n", i, j, covariance[i][j] / n);
      EXPECT_NEAR(covariance[i][j] / n, i == j ? 0.2 : 0.0, 0.004);
    }
  }
}

// Stiffness over mass of each node (redraw_stiffest.h), from the finished mesh.
std::vector<double> stiffness_over_mass(const Realization& made) {
  std::vector<double> stiffness(made.nodes.size(), 0);
  std::vector<double> mass(made.nodes.size(), 0);
  for (const Tetrahedron& t : made.tetrahedra) {
    const auto node = [&](std::size_t k) { return made.nodes[index(t[k % 4])]; };
    const double volume = signed_volume(node(0), node(1), node(2), node(3));
    for (std::size_t k = 0; k < 4; ++k) {
      const Point area = cross(node(k + 2) - node(k + 1), node(k + 3) - node(k + 1)) / 2;
      stiffness[index(t[k])] += dot(area, area) / (9 * volume);
      mass[index(t[k])] += volume / 4;
    }
  }
  for (std::size_t i = 0; i < mass.size(); ++i) stiffness[i] /= mass[i];
  return stiffness;
}

// The nodes that would need the shortest steps are redrawn: without that, the mean is 1.24.
TEST_F(PlateRealization, NoOutlierDecidesTheStableStep) {
  constexpr int n_samples = 6;
  double mean = 0;
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    const std::vector<double> stiffness = stiffness_over_mass(make(2012, sample));
    std::vector<std::pair<double, double>> nodes;  // by the value for their spacing
    for (std::size_t i = 0; i < stiffness.size(); ++i)
      nodes.emplace_back(stiffness[i] * base().spacing[i] * base().spacing[i], stiffness[i]);
    std::ranges::sort(nodes);
    nodes.resize(nodes.size() * 99 / 100);
    const double ratio =
        std::ranges::max(stiffness) / std::ranges::max(nodes, {}, &std::pair<double, double>::second).second;
    std::printf("%zu nodes: stiffest %.3f times those without outliers for their spacing\n", stiffness.size(),
                ratio);
    mean += ratio / n_samples;
  }
  EXPECT_LT(mean, 1.1);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
