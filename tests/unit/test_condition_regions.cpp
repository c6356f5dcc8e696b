// SPDX-License-Identifier: GPL-3.0-or-later
// Loads and supports on parts of faces: their location is equal in every realization, to the last digits.
#include "geometry/condition_region.h"
#include "geometry/symmetry.h"
#include "mechanics/conditions.h"

#include "support/job.h"
#include "support/plate_family.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::mechanics {
namespace CRACKLE_TEST_FILE {

using test::PlateText;
using ::testing::HasSubstr;

constexpr double mm = 1e-3;

input::Parameters parsed(PlateText plate, const std::string& boundaries) {
  plate.boundaries = boundaries;
  input::Parameters parameters = input::parse(plate.text(), "plate.toml");
  parameters.seed = 3;
  return parameters;
}

/// Area or length of a region, and resultant and moment about the origin of a condition, per amplitude.
struct Wrench {
  double size = 0;
  Vector force{};
  Vector moment{};
};

/// A condition's force patterns along x, y and z in one sample.
Wrench wrench_of(const input::Parameters& parameters, int condition, std::uint64_t sample) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto subdomain = test::whole(test::realization(parameters, sample));
  const Conditions loads = make_boundary_loads(self, parameters, subdomain);
  Wrench wrench;
  for (const ForcePattern& pattern : loads.forces) {
    if (pattern.condition != condition) continue;
    wrench.size = pattern.total_weight;
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
      Vector force{};
      force[index(pattern.component)] = pattern.weight[i];
      wrench.force = wrench.force + force;
      wrench.moment = wrench.moment + cross(subdomain.nodes[index(pattern.nodes[i])], force);
    }
  }
  return wrench;
}

/// For a load of 1 along `direction`, uniform over a size with the given centroid.
void expect_wrench(const input::Parameters& parameters, int condition, double size, const Vector& centroid,
                   const Vector& direction) {
  for (std::uint64_t sample = 0; sample < 3; ++sample) {
    const Wrench found = wrench_of(parameters, condition, sample);
    const Vector moment = cross(centroid, size * direction);
    double error = std::abs(found.size - size) / size;
    const double arm = norm(centroid) + mm;
    for (std::size_t i = 0; i < 3; ++i) {
      error = std::max(error, std::abs(found.force[i] - size * direction[i]) / size);
      error = std::max(error, std::abs(found.moment[i] - moment[i]) / (size * arm));
    }
    std::printf("condition %d, sample %d: size %.9g, relative error of size, force and moment %.1e\n",
                condition, static_cast<int>(sample), found.size, error);
    EXPECT_LT(error, 1e-12);
  }
}

const PlateText box{.specimen = R"(size = ["2 mm", "20 mm", "40 mm"])",
                    .notches = {R"(face = "y-min"
at = "20 mm"
depth = "6 mm"
height = "1 mm")"},
                    .mesh = "spacing = \"2 mm\""};

constexpr const char* held = R"([[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
)";

std::string refusal(const PlateText& plate, const std::string& boundaries) {
  try {
    geometry::make_body(parsed(plate, boundaries));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

std::string traction_on(const std::string& face, const std::string& region) {
  return "[[boundary]]\non = \"" + face + "\"\nregion = " + region +
         "\ntraction = [\"1 MPa\", \"1 MPa\", \"1 MPa\"]\n";
}

TEST(ConditionRegion, TractionOnPartOfABoxHasTheForceAndMomentOfTheInput) {
  const auto parameters = parsed(box, held + traction_on("z-max", R"({ y = ["7.5 mm", "12.5 mm"] })"));
  expect_wrench(parameters, 1, 10 * mm * mm, {1 * mm, 10 * mm, 40 * mm}, {1, 1, 1});
}

TEST(ConditionRegion, MayBeSmallerThanTheSpacingAndEndInTheThickness) {
  const auto parameters =
      parsed(box, held + traction_on("y-max", R"({ x = ["0.5 mm", "1.2 mm"], z = ["29.9 mm", "30.1 mm"] })"));
  expect_wrench(parameters, 1, 0.14 * mm * mm, {0.85 * mm, 20 * mm, 30 * mm}, {1, 1, 1});
}

TEST(ConditionRegion, MayOverlapAnotherOne) {
  const auto parameters =
      parsed(box, held + traction_on("x-max", R"({ y = ["8 mm", "14 mm"], z = ["5 mm", "9 mm"] })") +
                      traction_on("x-max", R"({ y = ["11 mm", "17 mm"], z = ["7 mm", "12 mm"] })"));
  expect_wrench(parameters, 1, 24 * mm * mm, {2 * mm, 11 * mm, 7 * mm}, {1, 1, 1});
  expect_wrench(parameters, 2, 30 * mm * mm, {2 * mm, 14 * mm, 9.5 * mm}, {1, 1, 1});
}

TEST(ConditionRegion, LeavesOutTheMouthOfASlot) {
  const auto parameters = parsed(box, held + traction_on("y-min", R"({ z = ["17 mm", "24 mm"] })"));
  // 2.5 mm below and 3.5 mm above the mouth.
  expect_wrench(parameters, 1, 12 * mm * mm, {1 * mm, 0, (2.5 * 18.25 + 3.5 * 22.25) / 6 * mm}, {1, 1, 1});
}

TEST(ConditionRegion, OnAnObliqueEdge) {
  // The edge from (20, 0) to (10, 30) mm between z = 6 and z = 9 mm.
  const PlateText plate{.specimen = R"(thickness = "3 mm"
outline = [["0 mm", "0 mm"], ["20 mm", "0 mm"], ["10 mm", "30 mm"], ["0 mm", "30 mm"]])",
                        .mesh = "spacing = \"2 mm\""};
  const auto parameters =
      parsed(plate, held + traction_on("edge-1", R"({ x = ["1 mm", "3 mm"], z = ["6 mm", "9 mm"] })"));
  const double length = 3 * std::sqrt(10.0) / 3;
  expect_wrench(parameters, 1, 2 * length * mm * mm, {2 * mm, (20 - 2.5) * mm, 7.5 * mm}, {1, 1, 1});
}

TEST(ConditionRegion, OnAnArcIsTheSameInEverySample) {
  const PlateText disk{.specimen = R"(thickness = "3 mm"
outline = "circle"
radius = "10 mm")",
                       .mesh = "spacing = \"1.5 mm\""};
  const auto parameters = parsed(disk, R"([[boundary]]
on = "edge-0"
region = { z = ["0 mm", "0.3 mm"] }
fix = ["x", "y", "z"]
)" + traction_on("edge-0", R"({ z = ["19.7 mm", "20 mm"] })"));
  const Wrench first = wrench_of(parameters, 1, 0);
  // The arc length is 2 R acos(1 - 0.3 / 10); chords are slightly shorter.
  const double arc = 20 * std::acos(1 - 0.03) * 3;
  std::printf("arc %.6f mm^2, chords %.6f mm^2\n", arc, first.size / mm / mm);
  // Four chords, cut off at exactly 0.3 mm.
  EXPECT_NEAR(first.size / mm / mm, arc, 0.01 * arc);
  EXPECT_LT(first.size / mm / mm, arc);
  for (std::uint64_t sample = 1; sample < 4; ++sample) {
    const Wrench found = wrench_of(parameters, 1, sample);
    EXPECT_NEAR(found.size, first.size, 1e-12 * first.size);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(found.force[i], first.force[i], 1e-12 * first.size);
      EXPECT_NEAR(found.moment[i], first.moment[i], 1e-12 * first.size * 0.02);
    }
  }
}

std::string roller_at(const std::string& face, const std::string& region) {
  return "[[boundary]]\non = \"" + face + "\"\nregion = " + region +
         "\nforce = [\"0 N\", \"-8 N\", \"0 N\"]\n";
}

TEST(ConditionRegion, WithoutWidthIsALineOfNodes) {
  for (const auto& [face, y] : {std::pair{"y-max", 20.0}, std::pair{"y-min", 0.0}}) {
    const auto parameters = parsed(box, held + roller_at(face, R"({ z = ["33.3 mm", "33.3 mm"] })"));
    for (std::uint64_t sample = 0; sample < 3; ++sample) {
      const parallel::Communicator self(MPI_COMM_SELF);
      const auto subdomain = test::whole(test::realization(parameters, sample));
      const Conditions loads = make_boundary_loads(self, parameters, subdomain);
      ASSERT_EQ(loads.forces.size(), 1u);
      const ForcePattern& pattern = loads.forces.front();
      EXPECT_GE(pattern.nodes.size(), 2u);
      double sum = 0;
      double moment = 0;
      for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
        const geometry::Point& p = subdomain.nodes[index(pattern.nodes[i])];
        EXPECT_NEAR(p[1], y * mm, 1e-15);
        EXPECT_NEAR(p[2], 33.3 * mm, 1e-15);
        sum += pattern.weight[i];
        moment += pattern.weight[i] * p[0];
      }
      EXPECT_NEAR(sum, 1, 1e-12);
      EXPECT_NEAR(moment, 1 * mm, 1e-12 * mm);
    }
  }
}

TEST(ConditionRegion, WithoutWidthMayEndInTheFaceOrBeAPoint) {
  const auto line =
      parsed(box, held + roller_at("x-max", R"({ y = ["9 mm", "9 mm"], z = ["30 mm", "33 mm"] })"));
  const Wrench of_line = wrench_of(line, 1, 0);
  EXPECT_NEAR(of_line.moment[2] / of_line.force[1], 2 * mm, 1e-12 * mm);
  EXPECT_NEAR(-of_line.moment[0] / of_line.force[1], 31.5 * mm, 1e-12 * mm);
  const auto point =
      parsed(box, held + roller_at("x-max", R"({ y = ["9 mm", "9 mm"], z = ["30 mm", "30 mm"] })"));
  const Wrench of_point = wrench_of(point, 1, 1);
  EXPECT_NEAR(of_point.force[1], 1, 1e-15);
  EXPECT_NEAR(-of_point.moment[0], 30 * mm, 1e-15);
}

TEST(ConditionRegion, ALineMayLieOnTheLipOfASlot) {
  for (const char* const z : {"19.5 mm", "20.5 mm"}) {
    const std::string at = std::string(R"({ z = [")") + z + "\", \"" + z + "\"] }";
    const Wrench found = wrench_of(parsed(box, held + roller_at("y-min", at)), 1, 0);
    EXPECT_NEAR(found.force[1], 1, 1e-12);
    EXPECT_NEAR(-found.moment[0], std::stod(z) * mm, 1e-15);
  }
  EXPECT_THAT(refusal(box, held + roller_at("y-min", R"({ z = ["20 mm", "20 mm"] })")),
              HasSubstr("lies in the opening of specimen.notch[0]"));
}

TEST(ConditionRegion, APointMayLieOnALineOrOnTheBorderOfARegion) {
  const std::string line = roller_at("x-max", R"({ y = ["9 mm", "9 mm"], z = ["30 mm", "36 mm"] })");
  const std::string part = roller_at("x-max", R"({ y = ["9 mm", "12 mm"], z = ["30 mm", "36 mm"] })");
  for (const std::string& other : {line, part})
    for (const char* const z : {"30 mm", "33 mm", "36 mm"}) {
      const std::string at = std::string(R"({ y = ["9 mm", "9 mm"], z = [")") + z + "\", \"" + z + "\"] }";
      const auto parameters = parsed(box, held + other + roller_at("x-max", at));
      const Wrench of_point = wrench_of(parameters, 2, 0);
      EXPECT_NEAR(of_point.force[1], 1, 1e-15);
      EXPECT_NEAR(-of_point.moment[0], std::stod(z) * mm, 1e-15);
      EXPECT_NEAR(wrench_of(parameters, 1, 0).force[1], 1, 1e-12);
    }
}

TEST(ConditionRegion, SupportsAreWhereTheInputSays) {
  const auto parameters = parsed(box, R"([[boundary]]
on = "y-min"
region = { z = ["9.9 mm", "10.1 mm"] }
fix = ["x", "y", "z"]
)");
  for (std::uint64_t sample = 0; sample < 3; ++sample) {
    const parallel::Communicator self(MPI_COMM_SELF);
    const auto subdomain = test::whole(test::realization(parameters, sample));
    const Conditions loads = make_boundary_loads(self, parameters, subdomain);
    ASSERT_EQ(loads.motions.size(), 3u);
    double lower = 1;
    double upper = 0;
    for (const auto node : loads.motions.front().nodes) {
      lower = std::min(lower, subdomain.nodes[index(node)][2]);
      upper = std::max(upper, subdomain.nodes[index(node)][2]);
    }
    EXPECT_NEAR(lower, 9.9 * mm, 1e-15);
    EXPECT_NEAR(upper, 10.1 * mm, 1e-15);
  }
  const auto refinements = geometry::region_refinements(parameters);
  ASSERT_EQ(refinements.size(), 1u);
  EXPECT_EQ(refinements.front().condition, 0u);
  EXPECT_NEAR(refinements.front().spacing, 0.2 * mm, 1e-12);
}

TEST(ConditionRegion, TakesPartInTheSymmetriesOfTheBody) {
  const PlateText plain{.specimen = R"(size = ["2 mm", "20 mm", "40 mm"])", .mesh = "spacing = \"2 mm\""};
  const auto n_symmetries = [&](const std::string& region) {
    const auto parameters = parsed(plain, held + traction_on("z-max", region));
    return geometry::symmetries(*geometry::make_body(parameters), parameters.mesh).size();
  };
  EXPECT_EQ(n_symmetries(R"({ y = ["0 mm", "20 mm"] })"), 8u);
  EXPECT_EQ(n_symmetries(R"({ y = ["7.5 mm", "12.5 mm"] })"), 4u) << "not reflected along z";
  EXPECT_EQ(n_symmetries(R"({ y = ["7 mm", "12.5 mm"] })"), 2u) << "along x only";
}

TEST(ConditionRegion, IsNotCrossedByBoundaryTriangles) {
  using geometry::Containment;
  const auto body = geometry::make_body(
      parsed(box, held + traction_on("z-max", R"({ y = ["7.5 mm", "12.5 mm"], x = ["1 mm", "2 mm"] })")));
  const auto at = [](double x, double y, double z) { return geometry::Point{x * mm, y * mm, z * mm}; };
  const geometry::Point below = at(1.5, 7.4, 39);
  EXPECT_EQ(body->classify({at(1.2, 7, 40), at(1.8, 7, 40), at(1.5, 8, 40), below}), Containment::straddling);
  EXPECT_EQ(body->classify({at(1.2, 7, 40), at(1.8, 7, 40), at(1.5, 7.5, 40), below}), Containment::inside)
      << "touches it";
  EXPECT_EQ(body->classify({at(0.2, 7, 40), at(0.8, 7, 40), at(0.5, 8, 40), below}), Containment::inside)
      << "beside it";
  EXPECT_EQ(body->classify({at(1.2, 7, 39.5), at(1.8, 7, 40), at(1.5, 8, 40), below}), Containment::inside)
      << "with an edge on the face only";
  // The border's points move along it, its corners are fixed.
  EXPECT_EQ(body->movable(at(1.5, 7.5, 40)), 1);
  EXPECT_EQ(body->movable(at(1, 9, 40)), 2);
  EXPECT_EQ(body->movable(at(1, 7.5, 40)), 0);
  EXPECT_EQ(body->movable(at(0.5, 7.5, 40)), 3);
  const geometry::FaceId face = body->faces_named("z-max").front();
  const auto meeting = body->passage(face, at(1.5, 7, 40), at(1.5, 8, 40), 0.01 * mm);
  ASSERT_TRUE(meeting.has_value());
  EXPECT_LT(norm(*meeting - at(1.5, 7.5, 40)), 1e-15);
}

TEST(ConditionRegion, IsPartOfWhatAMeshFollowsFrom) {
  const auto settings = [](const std::string& region, const char* traction) {
    return input::settings_of(parsed(box, held + std::string("[[boundary]]\non = \"z-max\"\n") + region +
                                              "traction = [\"0 MPa\", \"0 MPa\", \"" + traction + "\"]\n"),
                              {input::Affects::body, input::Affects::points});
  };
  const std::string region = "region = { y = [\"7 mm\", \"12 mm\"] }\n";
  EXPECT_EQ(settings(region, "1 MPa"), settings(region, "2 MPa"));
  EXPECT_NE(settings(region, "1 MPa"), settings("region = { y = [\"7 mm\", \"13 mm\"] }\n", "1 MPa"));
  EXPECT_NE(settings(region, "1 MPa"), settings("", "1 MPa"));
}

TEST(ConditionRegion, RefusesWhatHoldsNothing) {
  EXPECT_THAT(refusal(box, held + traction_on("y-max", R"({ z = ["30 mm", "30 mm"] })")),
              HasSubstr("boundary[1].region.z: a line or a point has no area for \"traction\""));
  const PlateText ring{.specimen = R"(thickness = "3 mm"
outline = "circle"
radius = "10 mm")",
                       .holes = {"center = [\"10 mm\", \"10 mm\"]\nradius = \"4 mm\""},
                       .mesh = "spacing = \"1.5 mm\""};
  EXPECT_THAT(refusal(ring, "[[boundary]]\non = \"z-min\"\nfix = [\"x\", \"y\", \"z\"]\n" +
                                traction_on("x-max", R"({ y = ["9 mm", "11 mm"], z = ["9 mm", "11 mm"] })")),
              HasSubstr("boundary[1]: its region contains no part of \"x-max\""));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::mechanics
