// SPDX-License-Identifier: GPL-3.0-or-later
// Cracks that are there before any load.
#include "cracks/crack_surface.h"
#include "geometry/flaws.h"
#include "geometry/mother_points.h"
#include "geometry/pre_crack.h"
#include "geometry/realization.h"
#include "mechanics/operators.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

constexpr double mm = 1e-3;

plane::PreCrack ellipse(const Point& center, const plane::Point& semi_axes, const Vector& normal) {
  plane::PreCrack crack;
  crack.center = center;
  crack.semi_axes = semi_axes;
  crack.normal = normal;
  return crack;
}

/// A cube of 8 mm with some pre-cracks.
input::Model cube(std::vector<plane::PreCrack> cracks) {
  input::Model model;
  model.seed = 5;
  model.specimen.size = {8 * mm, 8 * mm, 8 * mm};
  model.specimen.cracks = std::move(cracks);
  model.mesh.spacing = model.mesh.notch_spacing = 0.7 * mm;
  model.mesh.perturbation = 0.2;
  return model;
}

/// The vector area that pre-cracks open, its facets on the side of the cracks' normal [m^2].
Vector opened_area(const input::Model& model) {
  const auto body = make_body(model);
  const auto points = make_mother_points(*body, model.mesh, model.seed);
  auto realization = make_realization(*body, points, model.mesh, model.seed, 0);
  realization.pre_crack = pre_crack_cuts(realization, model.specimen.cracks, body->bounds());
  std::vector<fracture::Break> breaks;
  for (std::size_t t = 0; t < realization.pre_crack.size(); ++t)
    if (const std::int32_t code = realization.pre_crack[t]; code != 0)
      breaks.push_back({static_cast<std::int64_t>(t), 0, 0, 1, 1, PreCrackCut::from(code).cut});
  realization.pre_crack.clear();
  Vector sum{};
  const PreCrackFigure figure(model.specimen.cracks.front(), body->bounds());
  for (const auto& facet : cracks::make_crack_surface(*body, realization, breaks, 0).facets) {
    const Vector area = 0.5 * cross(facet.corner[2] - facet.corner[0], facet.corner[3] - facet.corner[1]);
    sum = sum + (dot(area, figure.patch().axes[2]) < 0 ? -1.0 : 1.0) * area;
  }
  return sum;
}

void expect_area(const char* name, const plane::PreCrack& crack, const Vector& exact, double tolerance) {
  const Vector area = opened_area(cube({crack}));
  const double off = norm(area - exact) / norm(exact);
  std::printf("%s: opened %.3f mm^2 of %.3f mm^2, off by %.1f %%\n", name, 1e6 * norm(area),
              1e6 * norm(exact), 100 * off);
  EXPECT_LT(off, tolerance) << name;
}

TEST(PreCracks, OpenTheirOwnArea) {
  const Point middle{4 * mm, 4 * mm, 4 * mm};
  const double disk = std::numbers::pi * 9 * mm * mm;
  expect_area("disk", ellipse(middle, {3 * mm, 3 * mm}, {0, 0, 2}), {0, 0, disk}, 0.05);
  const Vector tilted = Vector{0.3, 0.5, 1} / norm(Vector{0.3, 0.5, 1});
  expect_area("tilted ellipse", ellipse(middle, {2 * mm, 3.5 * mm}, tilted),
              std::numbers::pi * 7 * mm * mm * tilted, 0.05);
  expect_area("half a disk", ellipse({0, 4 * mm, 4 * mm}, {3 * mm, 3 * mm}, {0, 0, 1}), {0, 0, disk / 2},
              0.05);
  plane::PreCrack line;
  line.line = {{{-1 * mm, 3.1 * mm}, {4 * mm, 3.1 * mm}}};
  expect_area("through the thickness", line, {0, 0, -8 * 4 * mm * mm}, 0.05);
  plane::PreCrack polygon;
  polygon.polygon = {{1 * mm, 1 * mm, 5 * mm}, {7 * mm, 1 * mm, 5 * mm}, {7 * mm, 7 * mm, 5 * mm}};
  expect_area("triangle", polygon, {0, 0, 18 * mm * mm}, 0.05);
}

TEST(PreCracks, PartTheNodesOnTheirTwoSides) {
  // Tetrahedra with each set of corners above the plane of a large disk.
  const PreCrackFigure figure(ellipse({0, 0, 0}, {100, 100}, {0, 0, 1}), {{-9, -9, -9}, {9, 9, 9}});
  const std::array<plane::Point, 4> places{{{0, 0}, {1, 0}, {0, 1}, {0.3, 0.3}}};
  for (unsigned above = 0; above < 16; ++above) {
    std::array<Point, 4> corners;
    for (std::size_t i = 0; i < 4; ++i)
      corners[i] = {places[i][0], places[i][1],
                    ((above >> i) & 1) != 0 ? 0.5 + 0.1 * static_cast<double>(i) : -0.5};
    const int cut = figure.cut(corners);
    if (above == 0 || above == 15) {
      EXPECT_EQ(cut, -1);
      continue;
    }
    // The vector area of the cut points to the group that it names first: across the plane, more or less.
    std::set<int> first;
    if (cut < 4)
      first = {cut};
    else
      first = {0, cut - 3};
    unsigned bits = 0;
    for (const int node : first) bits |= 1u << node;
    EXPECT_TRUE(bits == above || bits == (~above & 15u)) << above << " gave cut " << cut;
  }
}

TEST(PreCracks, AreCrackStartsBeforeTheFreeSurface) {
  input::Model model = cube({ellipse({4 * mm, 4 * mm, 4 * mm}, {1 * mm, 1 * mm}, {1, 0, 0})});
  model.specimen.holes = {
      {.center = {6 * mm, 6 * mm}, .polygon = {{5 * mm, 5 * mm}, {7 * mm, 5 * mm}, {7 * mm, 7 * mm}}}};
  model.specimen.shape = plane::Shape{{{{{0, 0}, {8 * mm, 0}, {8 * mm, 8 * mm}, {0, 8 * mm}}, {0, 1, 2, 3}},
                                       {{{7 * mm, 7 * mm}, {7 * mm, 5 * mm}, {5 * mm, 5 * mm}}, {4, 4, 4}}},
                                      {{"edge-0"}, {"edge-1"}, {"edge-2"}, {"edge-3"}, {"hole-0"}}};
  model.flaws.emplace_back().number = 2;
  const auto body = make_composite_body(model);
  std::vector<std::string> names;
  for (const CrackStart& start : body->crack_starts()) names.push_back(start.name);
  EXPECT_EQ(names, (std::vector<std::string>{"hole-0", "crack-0", "flaws", "free surface"}));
  EXPECT_EQ(n_crack_starts(model), names.size());
}

TEST(PreCracks, RestrictTheSymmetriesOfTheBody) {
  const Point middle{4 * mm, 4 * mm, 4 * mm};
  EXPECT_EQ(make_body(cube({}))->symmetries().size(), 8U);
  EXPECT_EQ(make_body(cube({ellipse(middle, {2 * mm, 1 * mm}, {0, 0, 1})}))->symmetries().size(), 8U);
  EXPECT_EQ(make_body(cube({ellipse(middle, {2 * mm, 1 * mm}, {0, 1, 1})}))->symmetries().size(), 4U);
  EXPECT_EQ(
      make_body(cube({ellipse({4 * mm, 4 * mm, 3 * mm}, {2 * mm, 1 * mm}, {0, 0, 1})}))->symmetries().size(),
      4U);
  // Two that are each other's image.
  const auto pair = make_body(cube({ellipse({4 * mm, 4 * mm, 3 * mm}, {2 * mm, 1 * mm}, {0, 0, 1}),
                                    ellipse({4 * mm, 4 * mm, 5 * mm}, {2 * mm, 1 * mm}, {0, 0, 1})}))
                        ->symmetries();
  ASSERT_EQ(pair.size(), 8U);
  EXPECT_EQ(pair.back().crack_start, (std::vector<std::int32_t>{1, 0}));
}

TEST(Flaws, FollowTheirDistributions) {
  input::Model model = cube({});
  input::Flaws& flaws = model.flaws.emplace_back();
  flaws.density = 0.05e9;
  flaws.region[2] = {0, 4 * mm};
  flaws.radii.unit = "m";
  flaws.radii.distribution = input::RandomDistribution::uniform;
  flaws.radii.lower = 0.5 * mm;
  flaws.radii.upper = 1.5 * mm;
  const auto body = make_body(model);
  constexpr int n_samples = 400;
  double n = 0, radius = 0, height = 0, along_z = 0;
  for (std::uint64_t sample = 0; sample < n_samples; ++sample)
    for (const plane::PreCrack& flaw : drawn_flaws(model, *body, sample)) {
      n += 1;
      radius += flaw.semi_axes[0];
      height += flaw.center[2];
      along_z += std::abs(flaw.normal[2]) / norm(flaw.normal);
      EXPECT_TRUE(body->contains(flaw.center) && flaw.center[2] <= 4 * mm);
    }
  const double expected = n_samples * 0.05 * 8 * 8 * 4;
  std::printf("%.0f flaws of %.0f, mean radius %.3f mm, height %.3f mm, |n_z| %.3f\n", n, expected,
              1e3 * radius / n, 1e3 * height / n, along_z / n);
  EXPECT_NEAR(n, expected, 4 * std::sqrt(expected));
  EXPECT_NEAR(radius / n, 1 * mm, 4 * 0.289 * mm / std::sqrt(n));
  EXPECT_NEAR(height / n, 2 * mm, 4 * 1.155 * mm / std::sqrt(n));
  EXPECT_NEAR(along_z / n, 0.5, 4 * 0.289 / std::sqrt(n));
}

TEST(Flaws, AreThoseOfTheSampleAndTheTable) {
  input::Model model = cube({ellipse({4 * mm, 4 * mm, 4 * mm}, {1 * mm, 1 * mm}, {1, 0, 0})});
  model.flaws.resize(2);
  for (input::Flaws& flaws : model.flaws) {
    flaws.number = 3;
    flaws.radius = 1 * mm;
    flaws.normal = {{0, 0, 1}};
  }
  model.flaws[1].spread = 0.1;
  const auto body = make_body(model);
  const auto cracks = pre_cracks(model, *body, 7), again = pre_cracks(model, *body, 7);
  const auto others = pre_cracks(model, *body, 8);
  ASSERT_EQ(cracks.size(), 7U);
  std::set<double> places;
  for (std::size_t i = 1; i < 7; ++i) {
    EXPECT_EQ(cracks[i].center, again[i].center);
    places.insert({cracks[i].center[0], others[i].center[0]});
  }
  EXPECT_EQ(places.size(), 12U);
  EXPECT_NEAR(dot(cracks[1].normal, cracks[2].normal), 1, 1e-15);
  EXPECT_LT(dot(cracks[4].normal, cracks[5].normal), 1 - 1e-6);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
