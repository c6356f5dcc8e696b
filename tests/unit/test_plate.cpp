// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies with any outline, with holes and slots in any direction: their geometry and their realizations.
//
// CRACKLE_FAMILY and CRACKLE_FAMILY_POINTS in the environment as for test_geometry_family.
#include "common/random.h"
#include "common/stopwatch.h"
#include "geometry/mother_points.h"
#include "geometry/realization.h"
#include "geometry/symmetry.h"

#include "input_samples.h"
#include "support/plate_family.h"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using test::PlateText;
using ::testing::HasSubstr;

constexpr double mm = 1e-3;

input::Parameters parsed(const PlateText& plate) {
  return input::parse(plate.text(), "plate.toml");
}

/// Bodies with oblique walls, arcs and re-entrant corners.
std::vector<PlateText> some_plates() {
  PlateText compact{R"(thickness = "2 mm"
outline = [["0 mm", "0 mm"], ["25 mm", "0 mm"], ["25 mm", "24 mm"], ["0 mm", "24 mm"]])"};
  compact.holes = {R"(center = ["5 mm", "6 mm"]
radius = "2.5 mm")",
                   R"(center = ["5 mm", "18 mm"]
radius = "2.5 mm")"};
  compact.notches = {R"(from = ["0 mm", "12 mm"]
to = ["13 mm", "12 mm"]
height = "1 mm"
end = "round")"};
  PlateText triangle{R"(thickness = "3 mm"
outline = [["0 mm", "0 mm"], ["25 mm", "10 mm"], ["7 mm", "33 mm"]])"};
  triangle.holes = {R"(center = ["10 mm", "15 mm"]
semi_axes = ["4 mm", "2 mm"]
angle = "30 degree")"};
  triangle.notches = {R"(from = ["0 mm", "0 mm"]
to = ["5 mm", "5 mm"]
height = "0.8 mm")"};
  PlateText disk{R"(thickness = "3 mm"
outline = "circle"
radius = "10 mm")"};
  disk.holes = {R"(polygon = [["8 mm", "8 mm"], ["8 mm", "12 mm"], ["12 mm", "12 mm"], ["12 mm", "8 mm"]])"};
  PlateText box{R"(size = ["2 mm", "20 mm", "30 mm"])"};
  box.notches = {R"(face = "y-max"
at = "20 mm"
depth = "4 mm"
height = "1 mm")",
                 R"(from = ["4 mm", "6 mm"]
to = ["11 mm", "12 mm"]
height = "1 mm")"};
  return {compact, triangle, disk, box};
}

TEST(PlateBody, SurfacesEncloseTheVolume) {
  for (const PlateText& plate : some_plates()) {
    const auto body = make_body(parsed(plate).specimen);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double flux = 0;
      double volume = 0;
      for (const Face& face : body->faces()) {
        const Point middle = face.patch.at((face.patch.domain.lower + face.patch.domain.upper) / 2);
        flux += face.outward[axis] * face.area;
        volume += face.outward[axis] * face.area * middle[axis];
        EXPECT_NEAR(norm(face.outward), 1, 1e-15);
      }
      EXPECT_NEAR(flux, 0, 1e-12 * body->faces()[0].area);
      EXPECT_NEAR(volume, body->volume(), 1e-12 * body->volume());
    }
    for (const Point& corner : body->corners()) {
      EXPECT_EQ(body->movable(corner), 0);
      int ends = 0;
      for (const Edge& edge : body->edges()) ends += (edge.from() == corner) + (edge.to() == corner);
      EXPECT_EQ(ends, 3);
    }
    for (const Edge& edge : body->edges()) {
      const Point p = edge.at(edge.length() / 3);
      ASSERT_TRUE(body->contains(p));
      const auto movable = body->movable(p);
      EXPECT_EQ(std::popcount(movable), 1);
      const Directions along = body->directions(body->place_of(p));
      ASSERT_EQ(along.n, 1);
      EXPECT_NEAR(std::abs(dot(along.vector[0], edge.to() - edge.from())), edge.length(),
                  1e-12 * edge.length());
    }
  }
}

TEST(PlateBody, PointsOnWallsStayThere) {
  for (const PlateText& plate : some_plates()) {
    const auto body = make_body(parsed(plate).specimen);
    for (std::size_t id = 0; id < body->faces().size(); ++id) {
      const Face& face = body->faces()[id];
      const Patch& patch = face.patch;
      if (id < 2) continue;
      const Point p = patch.at({patch.domain.upper[0] / 3, patch.domain.upper[1] / 3, 0});
      ASSERT_TRUE(body->contains(p));
      EXPECT_TRUE(body->in_face(static_cast<FaceId>(id), p));
      const auto movable = body->movable(p);
      EXPECT_EQ(std::popcount(movable), 2) << face.names[0];
      const Directions directions = body->directions(body->place_of(p));
      for (int k = 0; k < directions.n; ++k) {
        EXPECT_NEAR(dot(directions.vector[index(k)], face.outward), 0, 1e-15);
        const Point q = p + patch.domain.upper[1] / 7 * directions.vector[index(k)];
        EXPECT_TRUE(!body->contains(q) || body->movable(q) == movable);
      }
      EXPECT_LT(body->distance_to_surface(p), 1e-15);
      EXPECT_NEAR(body->distance_to_outline(static_cast<FaceId>(id), p),
                  std::min(patch.domain.upper[0], patch.domain.upper[1]) / 3, 1e-12);
      // From the material through the wall.
      const double step = patch.domain.upper[1] / 100;
      const auto found =
          body->passage(static_cast<FaceId>(id), p - step * face.outward, p + step * face.outward, 0);
      ASSERT_TRUE(found);
      EXPECT_NEAR(norm(*found - p), 0, 1e-15);
      const Point snapped = body->snapped(p + 1e-10 * face.outward, 1e-9);
      EXPECT_NEAR(norm(snapped - p), 0, 1e-15);
      EXPECT_TRUE(body->in_face(static_cast<FaceId>(id), snapped));
    }
  }
}

TEST(PlateBody, NamesOfFaces) {
  const auto body = make_body(parsed(some_plates()[0]).specimen);
  EXPECT_EQ(body->faces_named("edge-0").size(), 1u);
  EXPECT_EQ(body->faces_named("edge-0"), body->faces_named("z-min"));
  EXPECT_EQ(body->faces_named("edge-3").size(), 2u) << "on both sides of the slot";
  EXPECT_EQ(body->faces_named("y-min"), body->faces_named("edge-3"));
  EXPECT_GE(body->faces_named("hole-1").size(), 8u);
  EXPECT_GE(body->faces_named("notch-0").size(), 6u);
  EXPECT_TRUE(body->faces_named("hole-2").empty());
  ASSERT_EQ(body->crack_starts().size(), 4u);
  EXPECT_EQ(body->crack_starts()[0].faces, body->faces_named("notch-0"));
  EXPECT_EQ(body->crack_starts()[1].faces, body->faces_named("hole-0"));
  EXPECT_TRUE(body->crack_starts()[3].is_free_surface);
  // The round tip is at the end of the slot.
  double tip = 0;
  for (const FaceId face : body->crack_starts()[0].faces)
    tip = std::max(tip, body->faces()[index(face)].patch.bounds().upper[1]);
  EXPECT_NEAR(tip, 13 * mm, 1e-15);
}

// A clockwise outline keeps the names of its edges.
TEST(PlateBody, NumberOfCrackStartsFollowsFromTheInput) {
  std::vector<plane::Specimen> specimens{
      {{1, 2, 3}, {}}, {{1, 20, 30}, {{plane::Face::z_max, 5, 2, 1}, {plane::Face::y_min, 9, 2, 1}}}};
  for (const PlateText& plate : some_plates()) specimens.push_back(parsed(plate).specimen);
  for (const plane::Specimen& specimen : specimens) {
    input::Model model;
    model.specimen = specimen;
    EXPECT_EQ(n_crack_starts(model), make_composite_body(model)->crack_starts().size());
  }
}

TEST(PlateBody, OutlineInEitherDirection) {
  PlateText forwards{R"(thickness = "1 mm"
outline = [["0 mm", "0 mm"], ["9 mm", "1 mm"], ["8 mm", "9 mm"], ["1 mm", "7 mm"]])"};
  PlateText backwards{R"(thickness = "1 mm"
outline = [["0 mm", "0 mm"], ["1 mm", "7 mm"], ["8 mm", "9 mm"], ["9 mm", "1 mm"]])"};
  forwards.section = backwards.section = "5 mm";
  const auto one = make_body(parsed(forwards).specimen);
  const auto other = make_body(parsed(backwards).specimen);
  EXPECT_DOUBLE_EQ(one->volume(), other->volume());
  for (const auto& [edge, same] : {std::pair{"edge-0", "edge-3"}, {"edge-1", "edge-2"}, {"edge-3", "edge-0"}})
    EXPECT_EQ(one->faces()[index(one->faces_named(edge).at(0))].outward,
              other->faces()[index(other->faces_named(same).at(0))].outward);
}

TEST(PlateBody, Symmetries) {
  const auto codes = [](const PlateText& plate) {
    const auto body = make_body(parsed(plate).specimen);
    std::vector<int> found;
    for (const Symmetry& symmetry : body->symmetries()) {
      found.push_back(symmetry.code);
      for (const Point& corner : body->corners()) EXPECT_EQ(body->movable(symmetry.image(corner)), 0);
      for (const Face& face : body->faces()) {
        const Point middle = face.patch.at((face.patch.domain.lower + face.patch.domain.upper) / 2);
        EXPECT_TRUE(body->contains(symmetry.image(middle)) || face.names[0].starts_with("x-"));
      }
    }
    return found;
  };
  using Codes = std::vector<int>;
  EXPECT_EQ(codes(some_plates()[0]), (Codes{0, 1, 4, 5})) << "the holes change places";
  EXPECT_EQ(codes(some_plates()[1]), (Codes{0, 1}));
  EXPECT_EQ(codes(some_plates()[2]), (Codes{0, 1, 2, 3, 4, 5, 6, 7}));
  const auto body = make_body(parsed(some_plates()[0]).specimen);
  EXPECT_EQ(body->symmetries()[2].crack_start, (std::vector<std::int32_t>{0, 2, 1, 3}));
}

TEST(PlateBody, ASlotThatIsTheNewEndHasItsPlaceInTheSymmetries) {
  // A disk with a flat at the top: the slot's wall is z-max as well.
  PlateText disk{R"(thickness = "3 mm"
outline = "circle"
radius = "25 mm")"};
  disk.notches = {R"(from = ["0 mm", "50 mm"]
to = ["50 mm", "50 mm"]
height = "4 mm")"};
  const auto body = make_body(parsed(disk).specimen);
  ASSERT_EQ(body->faces_named("z-max").size(), 1U);
  const auto symmetries = body->symmetries();
  ASSERT_EQ(symmetries.size(), 4U) << "along x and y";
  for (const Symmetry& symmetry : symmetries)
    EXPECT_EQ(symmetry.crack_start, (std::vector<std::int32_t>{0, 1}));
}

/// Holes and slots that meet, their polygons known.
struct MeetingPlate {
  PlateText text;
  double area;  ///< [mm^2]; 0: not known in closed form
  double tip;   ///< y of the slot's end [mm]
};

std::vector<MeetingPlate> meeting_plates() {
  const PlateText plain{R"(size = ["2 mm", "20 mm", "24 mm"])"};
  PlateText keyhole = plain;  // a slot from the face to a hole, and one from the hole on
  keyhole.holes = {R"(center = ["8 mm", "12 mm"]
radius = "2 mm")"};
  keyhole.notches = {R"(face = "y-min"
at = "12 mm"
depth = "8 mm"
height = "1 mm")",
                     R"(from = ["10 mm", "12 mm"]
to = ["14 mm", "12 mm"]
height = "0.5 mm")"};
  PlateText cross = plain;
  cross.notches = {R"(from = ["6 mm", "12 mm"]
to = ["14 mm", "12 mm"]
height = "1 mm")",
                   R"(from = ["10 mm", "8 mm"]
to = ["10 mm", "16 mm"]
height = "1 mm")"};
  PlateText stepped = plain;  // a wide shallow notch with a narrow deep one
  stepped.notches = {R"(face = "y-min"
at = "12 mm"
depth = "4 mm"
height = "2 mm")",
                     R"(face = "y-min"
at = "12 mm"
depth = "7 mm"
height = "0.6 mm")"};
  PlateText square = plain;  // a slot from a corner of a square hole
  square.holes = {
      R"(polygon = [["6 mm", "10 mm"], ["10 mm", "10 mm"], ["10 mm", "14 mm"], ["6 mm", "14 mm"]])"};
  square.notches = {R"(from = ["8 mm", "12 mm"]
to = ["14 mm", "12 mm"]
height = "1 mm")"};
  return {{keyhole, 0, 14}, {cross, 480 - 15, 14}, {stepped, 480 - 8 - 1.8, 7}, {square, 480 - 16 - 4, 14}};
}

TEST(PlateBody, HolesAndSlotsMayMeet) {
  for (const auto& [text, area, tip] : meeting_plates()) {
    SCOPED_TRACE(text.text());
    const input::Parameters parameters = parsed(text);
    const auto body = make_body(parameters);
    if (area > 0) {
      EXPECT_NEAR(body->volume(), 2 * area * mm * mm * mm, 1e-12 * body->volume());
    }
    EXPECT_EQ(body->outline().size(), body->faces_named("y-min").size() == 1 ? 2u : 1u)
        << "one hole, or none";
    // Each part has its own name; cracks from the slot's tip start at the slot.
    const std::size_t slot = text.notches.size() - (text.holes.empty() && area == 465 ? 2 : 1);
    const std::vector<FaceId> walls = body->faces_named("notch-" + std::to_string(slot));
    EXPECT_GE(walls.size(), 3u);
    const CrackStart& start = body->crack_starts()[slot];
    EXPECT_EQ(start.faces, walls);
    const auto at_tip = std::ranges::find_if(walls, [&](FaceId face) {
      const Box bounds = body->faces()[index(face)].patch.bounds();
      return std::abs(bounds.lower[1] - tip * mm) < 1e-12 && std::abs(bounds.upper[1] - tip * mm) < 1e-12;
    });
    ASSERT_NE(at_tip, walls.end());
    EXPECT_TRUE(start.claims(*at_tip, {mm, tip * mm, 12 * mm}));
    const SpacingField spacing(*body, parameters.mesh);
    EXPECT_LE(spacing({mm, tip * mm, 12 * mm}), parameters.mesh.notch_spacing * 1.0001);
    const MotherPoints base = make_mother_points(*body, parameters.mesh, 7);
    for (std::uint64_t sample = 0; sample < 2; ++sample)
      make_realization(*body, base, parameters.mesh, 7, sample);  // verified
    for (std::size_t i = 0; i < text.holes.size(); ++i)
      EXPECT_GE(body->faces_named("hole-" + std::to_string(i)).size(), 4u);
  }
}

TEST(PlateBody, RealizationsConform) {
  for (const PlateText& plate : some_plates()) {
    const input::Parameters parameters = parsed(plate);
    const auto body = make_body(parameters.specimen);
    const MotherPoints base = make_mother_points(*body, parameters.mesh, 7);
    for (std::uint64_t sample = 0; sample < 4; ++sample) {
      const Realization made = make_realization(*body, base, parameters.mesh, 7, sample);
      EXPECT_GE(verify(made, *body, parameters.mesh.min_quality), parameters.mesh.min_quality);
    }
  }
}

TEST(PlateFamily, EveryPlateConformsOrIsRefusedForATrueReason) {
  const auto n_plates =
      static_cast<std::uint64_t>(test::from_environment("CRACKLE_FAMILY", test::repetitions(10, 80)));
  const double max_points = test::from_environment("CRACKLE_FAMILY_POINTS", 8000);
  std::map<std::string, int> refused;
  int n_conforming = 0;
  int n_refused = 0;
  double worst = 1;
  const Stopwatch clock;
  for (std::uint64_t number = 0; number < n_plates; ++number) {
    SCOPED_TRACE("plate " + std::to_string(number));
    const RandomStream stream(2, number, "random plates");
    test::RandomPlate plate;
    input::Parameters parameters;
    std::string refusal;
    for (std::uint64_t attempt = 0;; ++attempt) {
      plate = test::random_plate(stream.substream(attempt));
      refusal.clear();
      try {
        parameters = input::parse(plate.text(), "plate.toml");
        if (estimate_n_points(*make_body(parameters.specimen), parameters.mesh) <= max_points) break;
      } catch (const input::InputError& error) {
        refusal = error.what();
        if (number % 2 == 0) break;
      }
    }
    if (!refusal.empty()) {
      const std::string reason = plate.true_reason(refusal);
      EXPECT_NE(reason, "") << refusal << "\n" << plate.text();
      ++refused[reason];
      ++n_refused;
      continue;
    }
    EXPECT_EQ(plate.impossible(), "") << plate.text();
    try {
      const auto body = make_body(parameters.specimen);
      EXPECT_NEAR(body->volume(), plate.area() * parameters.specimen.size[0],
                  plate.area_tolerance() * parameters.specimen.size[0]);
      const MotherPoints base = make_mother_points(*body, parameters.mesh, number);
      for (std::uint64_t sample = 0; sample < 2; ++sample) {
        const Realization made = make_realization(*body, base, parameters.mesh, number, sample);
        worst =
            std::min(worst, verify(made, *body, parameters.mesh.min_quality) / parameters.mesh.min_quality);
      }
      ++n_conforming;
    } catch (const std::runtime_error& failure) {
      ADD_FAILURE() << failure.what() << "\n" << plate.text();
    }
  }
  std::printf("%lu plates in %.0f s: %d conform, %d are refused\n", static_cast<unsigned long>(n_plates),
              clock.seconds(), n_conforming, n_refused);
  for (const auto& [reason, count] : refused) std::printf("  refused, %s: %d\n", reason.c_str(), count);
  EXPECT_GE(worst, 1 - 1e-12);
  EXPECT_GE(n_conforming, static_cast<int>(n_plates / 2));
  EXPECT_GE(n_refused, static_cast<int>(n_plates / 20));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
