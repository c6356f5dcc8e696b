// SPDX-License-Identifier: GPL-3.0-or-later
// Cracks that start at a slanted slot, at a hole, on the free surface and inside the body.
#include "cracks/crack_ligaments.h"

#include "common/index.h"
#include "common/real.h"
#include "cracks/crack_line.h"
#include "cracks/crack_pattern.h"
#include "cracks/crack_speed.h"
#include "cracks/front_trajectory.h"
#include "cracks/section_crossings.h"
#include "geometry/outline.h"
#include "support/flat_cracks.h"
#include "support/structured_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

namespace crackle::cracks {
namespace CRACKLE_TEST_FILE {

using geometry::CrackStart;
using geometry::Point;
using test::direction;

constexpr double mm = 1e-3;
constexpr double thickness = 4 * mm;
constexpr double width = 60 * mm;
constexpr double length = 80 * mm;
const Point hole{thickness / 2, 30 * mm, 40 * mm};
constexpr double hole_radius = 5 * mm;  // to its eight sides

enum : std::int32_t { slot, round_hole, surface_start };

/// The analysis data of a plate with a slanted slot, of which only the tip matters, an octagonal hole and a
/// free surface.
class PlateWithHole : public geometry::Complex {
public:
  PlateWithHole() {
    bounds = {{0, 0, 0}, {thickness, width, length}};
    add_side({0, 0, length / 2}, {0, -1, 0}, length);
    add_side({0, width, length / 2}, {0, 1, 0}, length);
    add_side({0, width / 2, 0}, {0, 0, -1}, width);
    add_side({0, width / 2, length}, {0, 0, 1}, width);
    for (const double x : {0.0, thickness})
      faces.push_back({{"x"},
                       1,
                       {x > 0 ? 1.0 : -1.0, 0, 0},
                       {{{x, 0, 0}, {x, width, length}}, {}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}});

    CrackStart slanted{};
    slanted.name = "slot";
    slanted.tip = {thickness / 2, 10 * mm, 10 * mm};
    slanted.along = direction(30);
    slanted.across = direction(120);
    slanted.direction = 1;
    slanted.ligament = 50 * mm / slanted.along[1];
    slanted.end = slanted.tip + slanted.ligament * slanted.along;
    CrackStart around{};
    around.name = "hole";
    around.tip = hole;
    around.is_straight = false;
    geometry::Polygon octagon;
    for (int i = 0; i < 8; ++i) {
      const Vector outward = direction(45 * i);
      around.faces.push_back(static_cast<geometry::FaceId>(faces.size()));
      const Vector corner = hole + hole_radius / std::cos(std::numbers::pi / 8) * direction(45 * i + 22.5);
      add_side({0, hole[1] + hole_radius * outward[1], hole[2] + hole_radius * outward[2]}, -1 * outward,
               2 * hole_radius * std::tan(std::numbers::pi / 8));
      octagon.push_back({corner[1], corner[2]});
    }
    std::ranges::reverse(octagon);
    CrackStart anywhere{};
    anywhere.name = "free surface";
    anywhere.is_straight = false;
    anywhere.is_free_surface = true;
    crack_starts = {slanted, around, anywhere};
    outline = {{{0, 0}, {width, 0}, {width, length}, {0, length}}, octagon};
  }

private:
  /// Adds a rectangle through the thickness with this centre.
  void add_side(const Point& middle, const Vector& outward, double extent) {
    const Vector along{0, -outward[2], outward[1]};
    faces.push_back(
        {{"side"},
         1,
         outward,
         {{{0, 0, -extent / 2}, {thickness, 0, extent / 2}}, middle, {{{1, 0, 0}, outward, along}}}});
  }
};

/// Point on the hole's side facing in this direction.
Point rim(double degrees) {
  return hole + hole_radius * direction(degrees);
}

input::Sections lines(std::vector<input::SectionLine> given) {
  return {.y = {}, .z = {}, .lines = std::move(given)};
}

/// A line through a point, normal to the direction, from 7 mm on one side to 5 mm on the other.
input::SectionLine line_across(const Point& place, double degrees) {
  const Vector across = direction(degrees + 90);
  const Point from = place - 7 * mm * across;
  const Point to = place + 5 * mm * across;
  return {{from[1], from[2]}, {to[1], to[2]}};
}

std::vector<SectionCrossing> crossings_of(const CrackSurface& surface, const input::Sections& sections,
                                          const geometry::Body& plate) {
  return section_crossings(plate, surface, find_branches(plate, surface), planes_of(sections));
}

class CrackLigaments : public testing::Test {
protected:
  geometry::Body plate{PlateWithHole()};
  test::FlatCracks made{thickness};
};

TEST_F(CrackLigaments, AStraightStartHasItsLigamentWithAllItsCracks) {
  EXPECT_EQ(crack_ligaments(plate, {}, slot).size(), 1U);
  made.begin(slot);
  made.add(plate.crack_starts()[slot].tip, 30, 20 * mm, 500, 0);
  made.begin(slot);
  made.add({0, 40 * mm, 30 * mm}, 100, 4 * mm, 500, 1e-5);
  const CrackSurface surface = made.surface();
  const auto ligaments = crack_ligaments(plate, surface, slot);
  ASSERT_EQ(ligaments.size(), 1U);
  EXPECT_EQ(ligaments[0].facets.size(), surface.facets.size());
  EXPECT_EQ(ligaments[0].line.tip, plate.crack_starts()[slot].tip);
  EXPECT_EQ(ligaments[0].line.ligament, plate.crack_starts()[slot].ligament);
}

TEST_F(CrackLigaments, ASlantedSlotsCrackHasItsTrueSpeedLengthAndPlace) {
  made.begin(slot);
  const CrackStart& start = plate.crack_starts()[slot];
  made.add(start.tip, 30, 30 * mm, 500, 0);
  const CrackSurface surface = made.surface();
  EXPECT_NEAR(crossed_shares(plate, surface)[slot], 30 * mm / start.ligament, 0.02);
  EXPECT_NEAR(max_crack_speed(plate, front_trajectories(plate, surface, infinity)).largest, 500, 0.5);
  const Point place = start.tip + 12 * mm * start.along;
  const auto found =
      crossings_of(surface,
                   {.y = {place[1]},
                    .z = {place[2]},
                    .lines = {line_across(place, 30), line_across(place, 0), line_across(place, 100)}},
                   plate);
  EXPECT_NEAR(found[0].position, place[2], 1e-9);
  EXPECT_TRUE(std::isnan(found[1].position)) << "the ligament runs along it";
  EXPECT_NEAR(found[2].position, 7 * mm, 1e-9);
  EXPECT_NEAR(found[3].position, 7 * mm, 1e-9) << "oblique to the crack";
  EXPECT_TRUE(std::isnan(found[4].position)) << "the ligament runs along it";
}

TEST_F(CrackLigaments, AHolesCrackHasItsTrueSpeedLengthAndPlace) {
  made.begin(round_hole);
  made.add(rim(45), 45, 20 * mm, 400, 0);
  const CrackSurface surface = made.surface();
  const auto ligaments = crack_ligaments(plate, surface, round_hole);
  ASSERT_EQ(ligaments.size(), 1U);
  const CrackStart& line = ligaments[0].line;
  EXPECT_EQ(ligaments[0].facets.size(), surface.facets.size());
  EXPECT_NEAR(norm(line.tip - rim(45)), 0, 1e-9);
  EXPECT_NEAR(norm(line.along - direction(45)), 0, 1e-9);
  EXPECT_NEAR(dot(line.along, line.across), 0, 1e-12);
  const double ligament = 30 * mm * std::numbers::sqrt2 - hole_radius;  // up to the side y = 60 mm
  EXPECT_NEAR(line.ligament, ligament, 1e-9);
  EXPECT_NEAR(line.end[1], width, 1e-9);
  EXPECT_NEAR(crossed_shares(plate, surface)[round_hole], 20 * mm / ligament, 0.02);
  EXPECT_EQ(leading_start(plate, surface), round_hole);
  EXPECT_NEAR(max_crack_speed(plate, front_trajectories(plate, surface, infinity)).largest, 400, 0.4);
  EXPECT_EQ(classify(plate, surface), Pattern::other) << "not through";
  EXPECT_TRUE(std::isnan(pattern_overlap(plate, surface)));

  const auto traced = crack_lines(plate, surface, find_branches(plate, surface));
  ASSERT_EQ(traced.size(), 1U);
  const LinePoint &first = traced[0].points.front(), &last = traced[0].points.back();
  EXPECT_NEAR(std::hypot(last.y - first.y, last.z - first.z), 20 * mm, 1.1 * made.spacing());

  const Point place = rim(45) + 8 * mm * direction(45);
  const auto found = crossings_of(
      surface, lines({line_across(place, 45), line_across(place, 0), line_across(place, 110)}), plate);
  const std::size_t of_hole = 3 * round_hole;
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found[of_hole + i].position, 7 * mm, 1e-9) << i;
  EXPECT_TRUE(std::isnan(found[0].position)) << "of the slot";
}

TEST_F(CrackLigaments, ALineEndsWhereItEnds) {
  made.begin(round_hole);
  made.add(rim(0), 0, 20 * mm, 400, 0);
  const CrackSurface surface = made.surface();
  const double y = 40 * mm, z = hole[2];
  const auto found = crossings_of(surface,
                                  lines({{{y, z - 3 * mm}, {y, z + 1 * mm}},
                                         {{y, z + 1 * mm}, {y, z - 3 * mm}},
                                         {{y, z - 3 * mm}, {y, z - 1 * mm}},
                                         {{y, z + 1 * mm}, {y, z + 3 * mm}}}),
                                  plate);
  EXPECT_NEAR(found[4].position, 3 * mm, 1e-9);
  EXPECT_NEAR(found[5].position, 1 * mm, 1e-9);
  EXPECT_TRUE(std::isnan(found[6].position)) << "beyond its end";
  EXPECT_TRUE(std::isnan(found[7].position)) << "before its start";
  EXPECT_TRUE(found[7].branches.empty());
}

TEST_F(CrackLigaments, AKinkedCracksLigamentLeadsToItsEnd) {
  made.begin(round_hole);
  const double time = made.add(rim(0), 0, 8 * mm, 400, 0);
  const Point kink = rim(0) + 8 * mm * direction(0);
  made.add(kink, 50, 8 * mm, 400, time);
  const CrackSurface surface = made.surface();
  const auto ligaments = crack_ligaments(plate, surface, round_hole);
  ASSERT_EQ(ligaments.size(), 1U);
  const Vector& along = ligaments[0].line.along;
  EXPECT_NEAR(std::atan2(along[2], along[1]), 25 * std::numbers::pi / 180, 0.02);
  EXPECT_NEAR(max_crack_speed(plate, front_trajectories(plate, surface, infinity)).largest, 400, 4);
  const Point before = rim(0) + 4 * mm * direction(0);
  const Point after = kink + 4 * mm * direction(50);
  const auto found = crossings_of(surface, lines({line_across(before, 0), line_across(after, 50)}), plate);
  EXPECT_NEAR(found[2].position, 7 * mm, 1e-9);
  EXPECT_NEAR(found[3].position, 7 * mm, 1e-9);
  const auto traced = crack_lines(plate, surface, find_branches(plate, surface));
  ASSERT_EQ(traced.size(), 1U);
  EXPECT_EQ(traced[0].kinks, 1);
}

TEST_F(CrackLigaments, ACrackFromAHoleToBothSidesIsTwo) {
  // Connected, as if the rim between them had broken.
  made.begin(round_hole);
  made.add(rim(0), 0, 22 * mm, 400, 0);
  made.add(rim(180), 180, 12 * mm, 200, 1e-5);
  const CrackSurface surface = made.surface();
  auto ligaments = crack_ligaments(plate, surface, round_hole);
  ASSERT_EQ(ligaments.size(), 2U);
  if (ligaments[0].line.along[1] < 0) std::swap(ligaments[0], ligaments[1]);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(norm(ligaments[i].line.tip - rim(180.0 * static_cast<double>(i))), 0, 1e-9);
    EXPECT_NEAR(norm(ligaments[i].line.along - direction(180.0 * static_cast<double>(i))), 0, 1e-6);
    EXPECT_NEAR(ligaments[i].line.ligament, 25 * mm, 1e-9);
  }
  EXPECT_EQ(ligaments[0].facets.size() + ligaments[1].facets.size(), surface.facets.size());
  EXPECT_NEAR(crossed_shares(plate, surface)[round_hole], 22.0 / 25, 0.02) << "the larger one";
  EXPECT_NEAR(max_crack_speed(plate, front_trajectories(plate, surface, infinity)).largest, 400, 0.5);
  EXPECT_EQ(classify(plate, surface), Pattern::two_cracks);
  const auto traced = crack_lines(plate, surface, find_branches(plate, surface));
  ASSERT_EQ(traced.size(), 2U);
  for (const CrackLine& line : traced) {
    EXPECT_EQ(line.parent, -1);
    EXPECT_EQ(line.start, round_hole);
  }
}

TEST_F(CrackLigaments, OneOfBothSidesIsOneCrack) {
  made.begin(round_hole);
  made.add(rim(90), 90, 33 * mm, 400, 0);
  made.add(rim(270), 270, 6 * mm, 400, 0);
  EXPECT_EQ(crack_ligaments(plate, made.surface(), round_hole).size(), 2U);
  EXPECT_EQ(classify(plate, made.surface()), Pattern::one_crack);
}

TEST_F(CrackLigaments, ACrackIntoAHoleAndOneOutOfItAreOneThroughTheHole) {
  const auto cracks = [&](bool goes_on, double length_behind) {
    test::FlatCracks both{thickness};
    both.begin(surface_start);
    const double time = both.add({0, 0, hole[2]}, 0, 25 * mm, 400, 0);
    if (goes_on)
      both.go_on(surface_start, round_hole, 0);
    else
      both.begin(round_hole);
    both.add(rim(20), 20, length_behind, 400, time);
    return both.surface();
  };
  EXPECT_EQ(classify(plate, cracks(false, 26.6 * mm)), Pattern::two_cracks) << "if they were two";

  const CrackSurface surface = cracks(true, 26.6 * mm);
  EXPECT_EQ(classify(plate, surface), Pattern::one_crack);
  EXPECT_EQ(leading_start(plate, surface), surface_start);
  EXPECT_GE(crossed_shares(plate, surface)[surface_start], 0.98);
  EXPECT_EQ(crossed_shares(plate, surface)[round_hole], 0);
  const auto through = crack_ligaments(plate, surface, Followed::through_holes);
  ASSERT_EQ(through.size(), 2U) << "with the slot's";
  EXPECT_EQ(through[1].facets.size(), surface.facets.size());
  EXPECT_NEAR(norm(through[1].line.tip - Point{thickness / 2, 0, hole[2]}), 0, 1e-9);

  const auto found = crossings_of(surface, {.y = {10 * mm, 30 * mm, 50 * mm}, .z = {}}, plate);
  const std::size_t of_surface = 3 * surface_start;
  EXPECT_NEAR(found[of_surface].position, hole[2], 1e-9);
  EXPECT_TRUE(std::isnan(found[of_surface + 1].position)) << "in the hole";
  EXPECT_NEAR(found[of_surface + 2].position, hole[2] + 20 * mm * std::tan(20 * std::numbers::pi / 180),
              1e-9);
  EXPECT_TRUE(std::isnan(found[3 * round_hole + 2].position));

  EXPECT_EQ(leaders_hole(plate, surface, surface_start).hole, round_hole);
  EXPECT_EQ(leaders_hole(plate, surface, surface_start).passage, HolePassage::passes);
  EXPECT_EQ(leaders_hole(plate, cracks(true, 2 * mm), surface_start).passage, HolePassage::ends) << "strays";
  EXPECT_EQ(leaders_hole(plate, cracks(false, 26.6 * mm), surface_start).hole, -1);

  // Its parts are traced and timed one by one.
  const auto lines = crack_lines(plate, surface, find_branches(plate, surface));
  ASSERT_EQ(lines.size(), 2U);
  for (const CrackLine& line : lines) EXPECT_EQ(line.start, surface_start);
  EXPECT_NEAR(max_crack_speed(plate, front_trajectories(plate, surface, infinity)).largest, 400, 1);
}

TEST_F(CrackLigaments, InsideTheBodyCracksRunToBothSides) {
  made.begin(surface_start);
  const Point place{thickness / 2, 20 * mm, 60 * mm};
  made.add(place, 20, 15 * mm, 300, 0);
  made.add(place, 200, 10 * mm, 300, 0);
  auto ligaments = crack_ligaments(plate, made.surface(), surface_start);
  ASSERT_EQ(ligaments.size(), 2U);
  if (ligaments[0].line.along[1] < 0) std::swap(ligaments[0], ligaments[1]);
  for (const CrackLigament& ligament : ligaments)
    EXPECT_NEAR(norm(ligament.line.tip - place), 0, made.step());
  EXPECT_NEAR(norm(ligaments[0].line.along - direction(20)), 0, 1e-2);
  EXPECT_NEAR(norm(ligaments[1].line.along - direction(200)), 0, 1e-2);
  EXPECT_NEAR(ligaments[0].line.ligament, 40 * mm / std::cos(20 * std::numbers::pi / 180), 0.5 * mm);
  EXPECT_NEAR(max_crack_speed(plate, front_trajectories(plate, made.surface(), infinity)).largest, 300, 3);
}

TEST_F(CrackLigaments, AcrossTheBodyACrackRunsFromTheSideWhereItOpenedFirst) {
  made.begin(surface_start);
  made.add({0, width, 20 * mm}, 180, 60 * mm, 300, 0);
  const auto ligaments = crack_ligaments(plate, made.surface(), surface_start);
  ASSERT_EQ(ligaments.size(), 1U);
  EXPECT_NEAR(ligaments[0].line.tip[1], width, 1e-9);
  EXPECT_NEAR(ligaments[0].line.tip[2], 20 * mm, 1e-9);
  EXPECT_NEAR(ligaments[0].line.ligament, 60 * mm, 1e-9);
  EXPECT_DOUBLE_EQ(crossed_shares(plate, made.surface())[surface_start], 1);
  EXPECT_EQ(classify(plate, made.surface()), Pattern::one_crack);
}

TEST_F(CrackLigaments, StrayBreaksHaveNone) {
  made.begin(surface_start);
  made.add({0, 59.5 * mm, 20 * mm}, 0, 0.4 * mm, 300, 0);
  made.begin(round_hole);
  made.add(rim(0), 0, 2 * mm, 300, 0);
  EXPECT_TRUE(crack_ligaments(plate, made.surface()).size() == 1) << "the slot's ligament alone";
  EXPECT_EQ(leading_start(plate, made.surface()), -1);
  EXPECT_EQ(classify(plate, made.surface()), Pattern::none);
}

TEST_F(CrackLigaments, TheOutlineHasNoDirectionWhereThereIsNone) {
  const geometry::Outline outline = geometry::outline_of(plate);
  EXPECT_EQ(outline.axis, (std::vector<std::int32_t>{1, 0, 0}));
  EXPECT_EQ(outline.direction, (std::vector<std::int32_t>{1, 0, 0}));
  EXPECT_EQ(outline.tips[2], hole[1]);
}

geometry::Body body_with_starts(std::vector<CrackStart> starts) {
  geometry::Complex complex = PlateWithHole();
  complex.crack_starts = std::move(starts);
  return geometry::Body(std::move(complex));
}

TEST(CrackStarts, TheFreeSurfaceHasWhatTouchesNoOtherOne) {
  const test::StructuredMesh mesh(test::notched_plate());
  // Cracks in the planes of both notches, and one of the second notch that does not touch it.
  const auto breaks = mesh.break_between(
      [](const Point& p) { return p[2] > 15.5  ? 2
                                  : p[2] > 8.5 ? 1
                                               : 0; },
      [](const Point& p) {
        return p[2] < 12 ? (p[1] < 9 ? 0.0 : -1.0) : p[1] < 9 ? 1.0 : p[1] > 11 ? 2.0 : -1.0;
      });
  const auto owners = [&](const std::vector<CrackStart>& starts) {
    std::vector<std::int32_t> found;
    for (const Crack& crack :
         make_crack_surface(body_with_starts(starts), mesh.realization(), breaks, 0).cracks)
      found.push_back(crack.start);
    return found;
  };
  std::vector<CrackStart> starts = mesh.body().crack_starts();
  using Owners = std::vector<std::int32_t>;
  EXPECT_EQ(owners(starts), (Owners{0, -1, 1}));
  CrackStart free_surface{};
  free_surface.is_straight = false;
  free_surface.is_free_surface = true;
  free_surface.faces = {0, 1, 2, 3, 4, 5};
  starts.push_back(free_surface);
  EXPECT_EQ(owners(starts), (Owners{0, 2, 1}));
  EXPECT_EQ(owners({starts[0], free_surface}), (Owners{0, 1, 1}));
  // Without a ligament any contact counts, even far behind the tip.
  CrackStart any = starts[1];
  EXPECT_FALSE(any.claims(any.faces[0], any.tip - 2 * any.reach * any.direction * any.along));
  any.is_straight = false;
  EXPECT_TRUE(any.claims(any.faces[0], any.tip - 2 * any.reach * any.direction * any.along));
  EXPECT_FALSE(any.claims(0, any.tip));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::cracks
