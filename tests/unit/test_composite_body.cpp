// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of several materials: where these are, and realizations that part them exactly.
#include "common/stopwatch.h"
#include "geometry/mother_points.h"
#include "geometry/partition.h"
#include "geometry/point.h"
#include "geometry/quality.h"
#include "geometry/realization.h"
#include "geometry/subdomain.h"
#include "geometry/symmetry.h"

#include "input_samples.h"

#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::geometry {
namespace CRACKLE_TEST_FILE {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double mm = 1e-3;

/// An input with three materials.
std::string text_of(const std::string& specimen, const std::string& mesh, const std::string& rest = "") {
  std::string text = "[ensemble]\nsamples = 3\n[specimen]\n" + specimen + "\n[mesh]\n" + mesh + "\n";
  for (const char* const name : {"matrix", "hard", "soft"})
    text += fmt::format(
        "[[material]]\nname = \"{}\"\nyoungs_modulus = \"3 GPa\"\npoisson_ratio = 0.3\ndensity = \"1200 "
        "kg/m^3\"\n",
        name);
  return text + rest + R"([fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[time]
duration = "100 us"
[[sections.line]]
from = ["-50 mm", "2.1 mm"]
to = ["50 mm", "2.2 mm"]
)";
}

input::Parameters parsed(const std::string& specimen, const std::string& spacing = "1 mm",
                         const std::string& rest = "") {
  return input::parse(text_of(specimen, "spacing = \"" + spacing + "\"\nbase = \"shared\"\n", rest),
                      "body.toml");
}

const std::string plate = R"(size = ["2 mm", "12 mm", "10 mm"])";

std::string region(const std::string& material, const std::string& keys) {
  return "\n[[specimen.region]]\nmaterial = \"" + material + "\"\n" + keys + "\n";
}

/// Several samples that conform, with their base points.
struct Family {
  input::Parameters parameters;
  std::unique_ptr<const Body> body;
  MotherPoints base;
  std::vector<Realization> samples;

  explicit Family(input::Parameters given, int n_samples = 3)
      : parameters(std::move(given)),
        body(make_body(parameters)),
        base(make_mother_points(*body, parameters.mesh, 7)) {
    for (int sample = 0; sample < n_samples; ++sample) {
      samples.push_back(
          make_realization(*body, base, parameters.mesh, 7, static_cast<std::uint64_t>(sample)));
      EXPECT_GE(samples.back().report.min_quality, parameters.mesh.min_quality);
    }
  }

  double volume(std::size_t material) const { return body->material_volumes().at(material); }
};

TEST(CompositeBody, ADiscHasTheVolumeOfItsChords) {
  const Family family(parsed(plate + region("hard", "center = [\"6 mm\", \"5 mm\"]\nradius = \"2 mm\"")));
  const plane::Polygon& chords = family.parameters.specimen.regions[0].outline;
  EXPECT_GE(chords.size(), 8U);
  EXPECT_NEAR(family.volume(1), plane::signed_area(chords) * 2 * mm, 1e-21);
  EXPECT_NEAR(family.volume(1) / (std::numbers::pi * 8 * mm * mm * mm), 1, 0.12);
  EXPECT_NEAR(family.volume(0) + family.volume(1), 240 * mm * mm * mm, 1e-20);
  EXPECT_EQ(family.body->inner_faces().size(), chords.size());
  EXPECT_EQ(family.body->faces().size(), 6U);
  for (const Realization& made : family.samples) {
    ASSERT_EQ(made.material.size(), made.tetrahedra.size());
    double hard = 0;
    for (std::size_t i = 0; i < made.tetrahedra.size(); ++i) {
      const Point centre = centroid(made.nodes, made.tetrahedra[i]);
      EXPECT_EQ(made.material[i], plane::holds(chords, {centre[1], centre[2]}));
      const auto& t = made.tetrahedra[i];
      if (made.material[i] == 1)
        hard += signed_volume(made.nodes[index(t[0])], made.nodes[index(t[1])], made.nodes[index(t[2])],
                              made.nodes[index(t[3])]);
    }
    EXPECT_NEAR(hard, family.volume(1), 1e-12 * family.volume(1));
    for (const BoundaryTriangle& triangle : made.boundary) EXPECT_LT(triangle.surface, 6);
  }
}

TEST(CompositeBody, PointsOnInnerFacesStayOnThem) {
  const Family family(parsed(R"(size = ["4 mm", "8 mm", "8 mm"])" +
                             region("hard",
                                    "polygon = [[\"1 mm\", \"4 mm\"], [\"4 mm\", \"1 mm\"], [\"7 mm\", \"4 "
                                    "mm\"], [\"4 mm\", \"7 mm\"]]\n"
                                    "x = [\"0 mm\", \"2 mm\"]")));
  int n_on_faces = 0, n_moved = 0;
  for (const Realization& made : family.samples) {
    const Symmetry symmetry = symmetry_of(*family.body, made.report.symmetry);
    for (std::size_t i = 0; i < family.base.size(); ++i) {
      const Point node = symmetry.preimage(made.nodes[i]);
      for (std::size_t k = 0; k < family.body->inner_faces().size(); ++k) {
        const auto face = static_cast<FaceId>(family.body->faces().size() + k);
        if (!family.body->in_face(face, family.base.position[i])) continue;
        EXPECT_LT(std::popcount(family.base.movable[i]), 3);
        EXPECT_EQ(family.body->movable(node), family.base.movable[i]);
        if (std::popcount(family.base.movable[i]) == 2) {
          EXPECT_TRUE(family.body->in_face(face, node));
          ++n_on_faces;
          n_moved += node != family.base.position[i];
        }
      }
    }
  }
  EXPECT_GT(n_on_faces, 3);
  EXPECT_EQ(n_moved, n_on_faces);
}

TEST(CompositeBody, LayersThroughTheThickness) {
  const Family family(parsed(R"(size = ["3 mm", "8 mm", "9 mm"])" +
                             region("hard", R"(x = ["0 mm", "1 mm"])") +
                             region("soft", R"(x = ["2 mm", "3 mm"])")));
  for (std::size_t material = 0; material < 3; ++material)
    EXPECT_NEAR(family.volume(material), 72 * mm * mm * mm, 1e-21);
  EXPECT_EQ(family.body->inner_faces().size(), 2U);
  EXPECT_EQ(family.body->material_at({0.5 * mm, mm, mm}), 1);
  EXPECT_EQ(family.body->material_at({1.5 * mm, mm, mm}), 0);
  EXPECT_EQ(family.body->material_at({2.5 * mm, mm, mm}), 2);
  EXPECT_EQ(family.body->movable({mm, 4 * mm, 4 * mm}), 6);
  EXPECT_EQ(family.body->movable({mm, 0, 4 * mm}), 4);
  EXPECT_EQ(family.body->movable({mm, 0, 0}), 0);
  EXPECT_EQ(family.body->symmetries().size(), 4U) << "not along x, as the outer layers differ";
  const Family sandwich(
      parsed(R"(size = ["3 mm", "8 mm", "9 mm"])" + region("hard", R"(x = ["0 mm", "1 mm"])") +
             region("hard", R"(x = ["2 mm", "3 mm"])")),
      4);
  EXPECT_EQ(sandwich.body->symmetries().size(), 8U);
  bool is_turned = false;
  for (const Realization& made : sandwich.samples) is_turned = is_turned || (made.report.symmetry & 1) != 0;
  EXPECT_TRUE(is_turned) << "so a reflection along x has been verified";
}

TEST(CompositeBody, ASlotThatEndsOnOrRunsAlongTheBoundary) {
  // The upper wall of the slot continues the boundary; then its middle does.
  for (const char* const at : {"4.8 mm", "5 mm"}) {
    SCOPED_TRACE(at);
    const Family family(parsed(plate + region("hard", R"(z = ["5 mm", "10 mm"])") +
                               fmt::format(R"(
[[specimen.notch]]
face = "y-min"
at = "{}"
depth = "4 mm"
height = "0.4 mm")",
                                           at)),
                        2);
    EXPECT_NEAR(family.volume(1), (std::string(at) == "5 mm" ? 60 - 0.8 : 60) * 2 * mm * mm * mm, 1e-20);
    EXPECT_EQ(family.body->inner_faces().size(), 1U);
    EXPECT_EQ(family.body->symmetries().size(), 2U);
  }
  const Family across(parsed(plate + region("hard", R"(y = ["4 mm", "12 mm"])") + R"(
[[specimen.notch]]
face = "y-min"
at = "5 mm"
depth = "4 mm"
height = "0.4 mm")"),
                      2);
  EXPECT_EQ(across.body->inner_faces().size(), 2U) << "above and below the slot, which ends on the boundary";
  EXPECT_NEAR(across.volume(1), 160 * mm * mm * mm, 1e-20);
}

TEST(CompositeBody, ACoatingThinnerThanTheSpacing) {
  const Family family(
      parsed(R"(size = ["2 mm", "5 mm", "6 mm"])" + region("hard", R"(y = ["0 mm", "0.4 mm"])"), "1 mm"), 2);
  EXPECT_NEAR(family.volume(1), 2 * 6 * 0.4 * mm * mm * mm, 1e-21);
  double finest = 1;
  for (const double spacing : family.base.spacing) finest = std::min(finest, spacing);
  EXPECT_NEAR(finest, 0.4 * mm, 1e-9);
  // Over the thickness, in the plane of the plate.
  const Family flat(
      parsed(R"(size = ["2 mm", "5 mm", "4 mm"])" + region("hard", R"(x = ["0 mm", "0.4 mm"])"), "1 mm"), 2);
  EXPECT_NEAR(flat.volume(1), 5 * 4 * 0.4 * mm * mm * mm, 1e-21);
}

TEST(CompositeBody, APolygonCutByAHoleAndTheEdge) {
  const Family family(
      parsed(plate + R"(
[[specimen.hole]]
center = ["6 mm", "6 mm"]
radius = "1.5 mm")" +
             region("hard", R"(polygon = [["6 mm", "6 mm"], ["14 mm", "3 mm"], ["14 mm", "9 mm"]])")));
  const Body& body = *family.body;
  EXPECT_EQ(body.material_at({mm, 9 * mm, 6 * mm}), 1);
  EXPECT_EQ(body.material_at({mm, 9 * mm, 8 * mm}), 0);
  EXPECT_EQ(body.inner_faces().size(), 2U);
  // The triangle up to the edge at y = 12 mm, without the sector of the hole, a polygon.
  EXPECT_NEAR(family.volume(1), 2 * (13.5 - std::atan2(3, 8) * 1.5 * 1.5) * mm * mm * mm, 0.4 * mm * mm * mm);
  double sum = 0;
  for (const double volume : body.material_volumes()) sum += volume;
  EXPECT_NEAR(sum, body.volume(), 1e-13 * body.volume());
}

TEST(CompositeBody, ABrickInABlock) {
  const Family family(parsed(
      R"(size = ["4 mm", "6 mm", "6 mm"])" +
      region("hard", "x = [\"1 mm\", \"3 mm\"]\ny = [\"2 mm\", \"4 mm\"]\nz = [\"1.5 mm\", \"4.5 mm\"]")));
  EXPECT_NEAR(family.volume(1), 12 * mm * mm * mm, 1e-21);
  EXPECT_EQ(family.body->inner_faces().size(), 6U);
  EXPECT_EQ(family.body->corners().size(), 16U);
  EXPECT_EQ(family.body->edges().size(), 24U);
  EXPECT_EQ(family.body->symmetries().size(), 8U);
  const Point corner{mm, 2 * mm, 1.5 * mm};
  EXPECT_EQ(family.body->movable(corner), 0);
  EXPECT_EQ(family.body->movable({2 * mm, 2 * mm, 1.5 * mm}), 1);
  EXPECT_EQ(family.body->movable({mm, 3 * mm, 1.5 * mm}), 2);
  EXPECT_EQ(family.body->movable({mm, 3 * mm, 3 * mm}), 6);
  EXPECT_EQ(family.body->movable({mm, 1 * mm, 3 * mm}), 7) << "beside the brick";
  EXPECT_NEAR(family.body->distance_to_surface({1.2 * mm, 1.6 * mm, 3 * mm}), 0.4 * mm, 1e-15);
  EXPECT_EQ(family.body->snapped(corner + Point{1e-12, -1e-12, 1e-12}, 1e-11), corner);
  EXPECT_EQ(family.body->snapped({2 * mm, 2 * mm + 1e-12, 3 * mm}, 1e-11), (Point{2 * mm, 2 * mm, 3 * mm}));
}

TEST(CompositeBody, RegionsThatTouchOrOverlap) {
  // At a corner, along a part of an edge, and one over both.
  const Family family(
      parsed(plate + region("hard", "y = [\"2 mm\", \"5 mm\"]\nz = [\"2 mm\", \"5 mm\"]") +
             region("soft", "y = [\"5 mm\", \"8 mm\"]\nz = [\"5 mm\", \"8 mm\"]") +
             region("soft", "y = [\"5 mm\", \"10 mm\"]\nz = [\"2 mm\", \"4 mm\"]\nx = [\"0 mm\", \"1 mm\"]") +
             region("matrix", "center = [\"5 mm\", \"5 mm\"]\nradius = \"1 mm\"")));
  const double circle = plane::signed_area(family.parameters.specimen.regions[3].outline);
  EXPECT_NEAR(family.volume(1), 18 * mm * mm * mm - circle / 4 * 2 * mm, 1e-20);
  EXPECT_NEAR(family.volume(2), 28 * mm * mm * mm - circle / 4 * 2 * mm, 1e-20);
  // A half-disc at an edge, and a region that makes no difference.
  const Family half(parsed(plate + region("hard", "center = [\"0 mm\", \"5 mm\"]\nradius = \"2.5 mm\"") +
                           region("matrix", R"(y = ["8 mm", "9 mm"])")));
  EXPECT_NEAR(half.volume(1), plane::signed_area(half.parameters.specimen.regions[0].outline) / 2 * 2 * mm,
              1e-20);
}

TEST(CompositeBody, OneMaterialEverywhereHasNoInnerFaces) {
  const Family family(
      parsed(plate + region("hard", R"(y = ["0 mm", "7 mm"])") + region("hard", R"(y = ["5 mm", "12 mm"])")),
      1);
  EXPECT_TRUE(family.body->inner_faces().empty());
  EXPECT_THAT(family.samples[0].material, ::testing::Each(1));
  EXPECT_EQ(family.body->corners().size(), 8U);
}

TEST(CompositeBody, InterfacesAreWhereTheirMaterialsMeet) {
  const Family family(
      parsed(plate + region("hard", R"(y = ["4 mm", "8 mm"])") + region("soft", R"(y = ["8 mm", "12 mm"])"),
             "1 mm", R"([[interface]]
between = ["soft", "hard"]
strength = "10 MPa"
[[interface]]
between = ["matrix", "soft"]
strength = "10 MPa"
)"),
      1);
  const Realization& made = family.samples[0];
  const Subdomain whole = split(made, partition(made, 1)).front();
  EXPECT_EQ(whole.material, made.material);
  EXPECT_EQ(whole.interface, made.interface);
  ASSERT_EQ(made.interface.size(), made.tetrahedra.size());
  for (std::size_t i = 0; i < made.tetrahedra.size(); ++i) {
    bool touches = false;
    for (const std::int32_t node : made.tetrahedra[i])
      touches = touches || made.nodes[index(node)][1] == 8 * mm;
    EXPECT_EQ(made.interface[i], touches ? 1 : 0);
  }
}

/// Qualities of tetrahedra with a node in some faces.
std::vector<double> qualities_at(const Realization& made, const std::function<bool(const Point&)>& is_there) {
  std::vector<double> result;
  for (const Tetrahedron& t : made.tetrahedra) {
    const auto node = [&](std::size_t k) -> const Point& { return made.nodes[index(t[k])]; };
    if (is_there(node(0)) || is_there(node(1)) || is_there(node(2)) || is_there(node(3)))
      result.push_back(mean_ratio(node(0), node(1), node(2), node(3)));
  }
  std::ranges::sort(result);
  return result;
}

TEST(CompositeBody, ShapesAtInnerFacesAreAsGoodAsAtTheSurface) {
  const Family family(
      parsed(R"(size = ["6 mm", "12 mm", "12 mm"])" + region("hard", R"(z = ["6 mm", "12 mm"])"), "1 mm"), 2);
  for (const Realization& made : family.samples) {
    const auto inner = qualities_at(made, [](const Point& p) { return p[2] == 6 * mm; });
    const auto outer = qualities_at(made, [](const Point& p) { return p[2] == 0 || p[2] == 12 * mm; });
    for (const double share : {0.02, 0.1, 0.5})
      EXPECT_GE(inner[static_cast<std::size_t>(share * static_cast<double>(inner.size()))],
                outer[static_cast<std::size_t>(share * static_cast<double>(outer.size()))] - 0.1)
          << share;
  }
}

std::vector<std::string> errors(const std::string& specimen) {
  return test::errors_of(text_of(specimen, "spacing = \"1 mm\""));
}

TEST(MaterialRegions, MistakesAreReported) {
  const auto with = [](const std::string& keys) { return errors(plate + region("hard", keys)); };
  EXPECT_THAT(with(""),
              ElementsAre(HasSubstr("test.toml:5: specimen.region[0]: has no shape; give a range of")));
  EXPECT_THAT(with("x = [\"0 mm\", \"1 mm\"]\nradius = \"1 mm\"\ncenter = [\"5 mm\", \"5 mm\"]\nsemi_axes = "
                   "[\"1 mm\", \"2 mm\"]"),
              ElementsAre(HasSubstr("specimen.region[0]: has several shapes")));
  EXPECT_THAT(with("y = [\"0 mm\", \"1 mm\"]\nradius = \"1 mm\"\ncenter = [\"5 mm\", \"5 mm\"]"),
              ElementsAre(HasSubstr("specimen.region[0].y: cannot be combined with radius")));
  EXPECT_THAT(with("radius = \"1 mm\""),
              ElementsAre(HasSubstr("specimen.region[0].center: the key is missing")));
  EXPECT_THAT(
      with("x = [\"3 mm\", \"4 mm\"]"),
      ElementsAre(HasSubstr("test.toml:7: specimen.region[0].x: the region from 3 mm to 4 mm is outside")));
  EXPECT_THAT(with("center = [\"20 mm\", \"5 mm\"]\nradius = \"2 mm\""),
              ElementsAre(HasSubstr("specimen.region[0]: contains nothing of the body")));
  EXPECT_THAT(with("polygon = [[\"1 mm\", \"1 mm\"], [\"3 mm\", \"3 mm\"], [\"3 mm\", \"1 mm\"], [\"1 mm\", "
                   "\"3 mm\"]]"),
              ElementsAre(HasSubstr("specimen.region[0].polygon: the polygon intersects itself")));
  EXPECT_THAT(
      errors(plate + region("hard", R"(z = ["2 mm", "4 mm"])") + region("soft", R"(z = ["1 mm", "5 mm"])")),
      ElementsAre(HasSubstr("specimen.region[0]: is hidden by the regions after it")));
  EXPECT_THAT(errors(plate + region("hart", R"(z = ["2 mm", "4 mm"])")),
              ElementsAre(HasSubstr(
                  "specimen.region[0].material: there is no material \"hart\"; give one of \"matrix\"")));
  EXPECT_THAT(with("polygon = [[\"0 mm\", \"5 mm\"], [\"12 mm\", \"4.8 mm\"], [\"12 mm\", \"5.2 mm\"]]"),
              ElementsAre(HasSubstr("the corner of specimen.region[0] at (0 mm, 5 mm) has")));
  EXPECT_THAT(with("z = [\"2 mm\", \"4 mm\"]"), ::testing::IsEmpty());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::geometry
