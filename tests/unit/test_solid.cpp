// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies from files: readers, checks, faces, and meshes that fill them exactly.
#include "solid/solid.h"

#include "geometry/condition_region.h"
#include "geometry/mother_points.h"
#include "geometry/quality.h"
#include "geometry/realization.h"

#include "support/effort.h"
#include "support/geometry_bodies.h"
#include "support/solid_files.h"

#include <gmock/gmock.h>
#include <boost/algorithm/string/case_conv.hpp>

#include <cstdio>
#include <map>
#include <set>

namespace crackle::solid {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;
using ::testing::UnorderedElementsAre;

Facets cube(double size = 5) {
  Facets facets;
  test::add_box(facets, {0, 0, 0}, {size, size, size});
  return facets;
}

Solid read(const std::string& content, const std::string& extension) {
  return read_solid(content, extension, "mm", 1e-3);
}

std::set<std::string> names_of(const Solid& solid) {
  std::set<std::string> names;
  for (const NamedFace& face : named_faces(solid)) names.insert(face.name);
  return names;
}

/// One content of each format.
std::map<std::string, std::pair<std::string, std::string>> all_formats() {
  return {{"text STL", {".stl", test::stl_of(cube())}},
          {"text STL in capitals", {".stl", boost::to_upper_copy(test::stl_of(cube()))}},
          {"binary STL", {".stl", test::binary_stl_of(cube())}},
          {"OBJ", {".obj", test::obj_of(cube())}},
          {"OFF", {".off", test::off_of(cube())}},
          {"text PLY", {".ply", test::ply_of(cube(), false)}},
          {"binary PLY", {".ply", test::ply_of(cube(), true)}},
          {"Gmsh 2.2", {".msh", test::gmsh_of_two_tetrahedra(false)}},
          {"Gmsh 4.1", {".msh", test::gmsh_of_two_tetrahedra(true)}},
          {"VTK 3.0", {".vtk", test::vtk_of_two_tetrahedra(false)}},
          {"VTK 5.1", {".vtk", test::vtk_of_two_tetrahedra(true)}}};
}

TEST(Solid, IsReadFromEachFormat) {
  for (const auto& [format, file] : all_formats()) {
    SCOPED_TRACE(format);
    const Solid solid = read(file.second, file.first);
    const bool is_cube = file.first != ".msh" && file.first != ".vtk";
    EXPECT_NEAR(solid.volume, is_cube ? 125e-9 : 2e-9 / 6, 1e-22);
    EXPECT_EQ(solid.faces.size(), 6u);
    EXPECT_EQ(solid.edges.size(), is_cube ? 12u : 9u);
    EXPECT_EQ(solid.content, file.second);
    double area = 0;
    for (const Face& face : solid.faces) area += face.area;
    if (is_cube) {
      EXPECT_NEAR(area, 150e-6, 1e-19);
    }
  }
}

TEST(Solid, NamesFacesByGroups) {
  for (const bool is_new : {false, true})
    EXPECT_THAT(names_of(read(test::gmsh_of_two_tetrahedra(is_new), ".msh")),
                UnorderedElementsAre("base", "tip", "face-0", "x-min", "y-min"));
  Facets grouped = cube();
  grouped.groups = {"bottom", "rest"};
  grouped.group = {1, 1, 1, 1, 0, 1};
  // An end has its own name beside that of its group.
  EXPECT_THAT(names_of(read(test::obj_of(grouped), ".obj")),
              UnorderedElementsAre("bottom", "rest", "x-min", "x-max", "y-min", "y-max", "z-min", "z-max"));
  // A group says something as long as other facets have none.
  grouped.groups = {"bottom"};
  grouped.group = {-1, -1, -1, -1, 0, -1};
  EXPECT_TRUE(names_of(read(test::obj_of(grouped), ".obj")).contains("bottom"));
  const std::string two = test::stl_of(cube(), "outer");
  Facets hole;
  test::add_box(hole, {1, 1, 1}, {2, 2, 2}, true);
  EXPECT_THAT(names_of(read(two + test::stl_of(hole, "inner"), ".stl")),
              UnorderedElementsAre("outer", "inner", "x-min", "x-max", "y-min", "y-max", "z-min", "z-max"));
}

/// A prism with so many sides, along x.
Facets prism(int n, double radius, double length) {
  Facets facets;
  Polygon lower, upper;
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * std::numbers::pi * i / n;
    for (const double x : {0.0, length})
      facets.points.push_back({x, radius * std::cos(turn), radius * std::sin(turn)});
    const auto first = index(2 * i), next = index(2 * ((i + 1) % n));
    facets.add({first, next, next + 1, first + 1});
    std::swap(facets.polygons.back()[1], facets.polygons.back()[3]);
    lower.insert(lower.begin(), first);
    upper.push_back(first + 1);
  }
  facets.add(lower);
  facets.add(upper);
  return facets;
}

TEST(Solid, HasPrintableNames) {
  Facets facets = cube();
  facets.groups = {"a\xff\x1b",
                   "Fl\xc3\xa4"
                   "che"};
  facets.group = {0, 0, 0, 1, 1, 1};
  const std::set<std::string> names = names_of(read(test::obj_of(facets), ".obj"));
  EXPECT_TRUE(names.contains("a??") && names.contains("Fl\xc3\xa4"
                                                      "che"));
}

TEST(Solid, NamesFacesByAngles) {
  const Solid round = read(test::stl_of(prism(40, 3, 4)), ".stl");
  const auto faces = named_faces(round);
  ASSERT_EQ(faces.size(), 5u);
  EXPECT_EQ(faces[0].name, "face-0");
  EXPECT_EQ(faces[0].n_planes, 40u);
  EXPECT_NEAR(faces[0].area, 40 * 2 * 3e-3 * std::sin(std::numbers::pi / 40) * 4e-3, 1e-18);
  EXPECT_NEAR(norm(faces[0].outward), 0, 1e-12);
  EXPECT_NEAR(norm(faces[0].centre - Vector{2e-3, 0, 0}), 0, 1e-15);
  EXPECT_EQ(faces[1].n_planes, 1u);
  EXPECT_EQ(faces[3].name, "x-min");
  EXPECT_EQ(faces[3].outward, (Vector{-1, 0, 0}));
  EXPECT_EQ(named_faces(read(test::stl_of(prism(12, 3, 4)), ".stl")).size(), 16u) << "30 degrees are an edge";
}

/// Fills a body in a few realizations, which verify volume, areas and quality.
void fill(const Solid& solid, double spacing_mm, std::uint64_t seed) {
  plane::Specimen specimen;
  specimen.solid = std::make_shared<const Solid>(solid);
  const auto body = geometry::make_body(specimen);
  EXPECT_EQ(body->volume(), solid.volume);
  input::Mesh mesh = testing::mesh(spacing_mm, spacing_mm, 0.2);
  mesh.min_quality = 0.15;
  const geometry::MotherPoints base = geometry::make_mother_points(*body, mesh, seed);
  for (std::uint64_t sample = 0; sample < 2; ++sample) {
    const geometry::Realization made = geometry::make_realization(*body, base, mesh, seed, sample);
    double volume = 0;
    for (const geometry::Tetrahedron& t : made.tetrahedra)
      volume += geometry::signed_volume(made.nodes[index(t[0])], made.nodes[index(t[1])],
                                        made.nodes[index(t[2])], made.nodes[index(t[3])]);
    EXPECT_NEAR(volume, solid.volume, 1e-12 * solid.volume);
  }
}

TEST(Solid, MergesFacetsOfAPlane) {
  // A cube with a grid of facets on each side.
  Facets fine;
  std::map<Vector, std::size_t> numbers;
  for (const Polygon& side : cube(3).polygons) {
    const Facets whole = cube(3);
    const auto at = [&](int i, int j) {
      const Vector &a = whole.points[side[0]], &b = whole.points[side[1]], &d = whole.points[side[3]];
      const Vector p = a + i / 3.0 * (b - a) + j / 3.0 * (d - a);
      const auto [entry, is_new] = numbers.emplace(p, fine.points.size());
      if (is_new) fine.points.push_back(p);
      return entry->second;
    };
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) fine.add({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  }
  // Also turned in space, where corners are in a plane up to rounding.
  for (const double turn : {0.0, 0.3}) {
    Facets turned = fine;
    for (Vector& p : turned.points) {
      const double c = std::cos(turn), s = std::sin(turn);
      p = {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
      p = {p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]};
    }
    const Solid solid = read(test::obj_of(turned), ".obj");
    EXPECT_EQ(solid.faces.size(), 6u);
    EXPECT_EQ(solid.edges.size(), 12u);
    EXPECT_NEAR(solid.volume, 27e-9, 1e-22);
    EXPECT_NEAR(solid.faces[0].area, 9e-6, 1e-19);
  }
}

TEST(Solid, FlattensFacesThatTheFileBends) {
  // A cylinder at an angle to all axes, in single precision.
  Facets leaning = prism(48, 3, 8);
  for (Vector& p : leaning.points) {
    p = {0.8 * p[0] - 0.6 * p[1], 0.6 * p[0] + 0.8 * p[1], p[2]};
    p = {p[0] + 3.3, 0.28 * p[1] - 0.96 * p[2] - 1.2, 0.96 * p[1] + 0.28 * p[2] + 7};
  }
  const Solid solid = read(test::binary_stl_of(leaning), ".stl");
  EXPECT_EQ(solid.faces.size(), 50u);
  EXPECT_EQ(solid.edges.size(), 3 * 48u);
  EXPECT_GT(solid.moved, 0);
  EXPECT_LT(solid.moved, 1e-8);
  const double exact = 48 * 0.5 * 9e-6 * std::sin(2 * std::numbers::pi / 48) * 8e-3;
  EXPECT_NEAR(solid.volume, exact, 1e-6 * exact);
  fill(solid, 1, 1);
  EXPECT_EQ(read(test::stl_of(prism(48, 3, 8)), ".stl").moved, 0);
}

TEST(Solid, OrientsItsFacets) {
  Facets mixed = cube();
  for (const std::size_t i : {0, 3, 4}) std::ranges::reverse(mixed.polygons[i]);
  for (const Facets& facets : {mixed, [] {
                                 Facets inward;
                                 test::add_box(inward, {0, 0, 0}, {5, 5, 5}, true);
                                 return inward;
                               }()})
    EXPECT_NEAR(read(test::off_of(facets), ".off").volume, 125e-9, 1e-22);
}

TEST(Solid, RefusesWhatIsNoBody) {
  const auto refuses = [](const Facets& facets, const auto& message) {
    EXPECT_THAT([&] { read(test::off_of(facets), ".off"); }, ThrowsMessage<std::runtime_error>(message));
  };
  Facets open = cube();
  open.polygons.pop_back();
  refuses(open, AllOf(HasSubstr("is not closed"),
                      HasSubstr("from (0, 0, 5) mm to (0, 5, 5) mm borders on one facet")));
  Facets two = cube();
  test::add_box(two, {6, 0, 0}, {7, 1, 1});
  refuses(two, HasSubstr("has 2 separate parts, such as at (0"));
  Facets crossing = cube();
  test::add_box(crossing, {4, 1, 1}, {7, 2, 2});
  refuses(crossing, HasSubstr("intersects itself"));
  Facets touching = cube();
  test::add_box(touching, {5, 5, 5}, {7, 7, 7});
  refuses(touching, HasSubstr("touches itself in the point (5, 5, 5) mm"));
  Facets along_edge = cube();
  test::add_box(along_edge, {5, 5, 0}, {7, 7, 5});
  refuses(along_edge, HasSubstr("4 facets meet at the edge from (5, 5, 0) mm to (5, 5, 5) mm"));
  Facets flat;
  flat.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.add({0, 1, 2});
  flat.add({0, 2, 1});
  EXPECT_ANY_THROW(read(test::off_of(flat), ".off"));
  Facets needle = cube();
  needle.points.push_back({2.5, 0, 0});
  needle.polygons[2] = {0, 1, 5, 4};
  needle.add({0, 8, 1});
  EXPECT_ANY_THROW(read(test::off_of(needle), ".off"));
  refuses(Facets{}, HasSubstr("has no facets"));
  Facets thin;
  test::add_box(thin, {0, 0, 0}, {5, 5, 1e-6});
  refuses(thin, HasSubstr("below 1e-06 of the body's size"));
  Facets folded = cube();
  folded.points[7] = {1e-320, 2, 1e-303};
  folded.points[6] = {0, 5 + 1e-6, 5 + 1e-11};
  refuses(folded, HasSubstr("has faces that lie on each other at"));
  EXPECT_THAT([] { read("", ".xyz"); }, ThrowsMessage<std::runtime_error>(HasSubstr("no known format")));
}

TEST(Solid, SaysWhereItIsSharp) {
  Facets wedge;
  wedge.points = {{0, 0, 0}, {5, 0, 0}, {5, 0.5, 0}, {0, 0, 3}, {5, 0, 3}, {5, 0.5, 3}};
  for (Polygon polygon : std::vector<Polygon>{{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}})
    wedge.add(std::move(polygon));
  const Sharpness sharp = sharpest(read(test::off_of(wedge), ".off"));
  EXPECT_NEAR(sharp.angle, std::atan(0.1), 1e-12);
  EXPECT_NEAR(sharp.place[0], 0, 1e-15);
  EXPECT_NEAR(sharpest(read(test::off_of(cube()), ".off")).angle, std::numbers::pi / 2, 1e-12);
  Facets hollow = cube();
  test::add_box(hollow, {1, 1, 1}, {2, 3, 4}, true);
  EXPECT_NEAR(sharpest(read(test::off_of(hollow), ".off")).angle, std::numbers::pi / 2, 1e-12);
}

TEST(Solid, KnowsWhatIsInIt) {
  Facets hollow = cube();
  test::add_box(hollow, {1, 1, 1}, {2, 3, 4}, true);
  const Solid solid = read(test::off_of(hollow), ".off");
  const auto holds = [&](double x, double y, double z) {
    return contains(solid, {1e-3 * x, 1e-3 * y, 1e-3 * z}, 1e-12);
  };
  EXPECT_TRUE(holds(0.5, 0.5, 0.5) && holds(4, 4, 4) && holds(0, 2, 2) && holds(5, 5, 5) && holds(1, 2, 2));
  EXPECT_FALSE(holds(1.5, 2, 2) || holds(6, 2, 2) || holds(-1e-3, 2, 2));
  constexpr std::pair<double, double> all{-1, 1};
  EXPECT_NEAR(area_in(solid, "z-max", "z-max", {all, all, all}), 25e-6, 1e-18);
  EXPECT_NEAR(area_in(solid, "z-max", "z-max", {std::pair{1e-3, 2e-3}, all, all}), 5e-6, 1e-18);
  EXPECT_EQ(area_in(solid, "z-max", "z-min", {all, all, all}), 0);
}

TEST(Solid, OfADamagedFileIsRefusedOrABody) {
  RandomStream stream(71, 0, "damaged files");
  int n_refused = 0, n_files = 0;
  for (const auto& [format, file] : all_formats())
    for (int i = 0; i < test::repetitions(12, 200); ++i) {
      std::string content = file.second;
      const auto place = [&] {
        return static_cast<std::size_t>(stream.uniform(0, static_cast<double>(content.size()) - 1));
      };
      if (i % 2 == 0)
        content.resize(place());
      else
        for (int k = 0; k < 3; ++k) content[place()] = static_cast<char>(stream.uniform(0, 256));
      ++n_files;
      try {
        const Solid solid = read(content, file.first);
        EXPECT_GT(solid.volume, 0);
      } catch (const std::runtime_error& error) {
        ++n_refused;
        EXPECT_THAT(std::string(error.what()), ::testing::Not(HasSubstr("\n"))) << format;
        EXPECT_LT(std::string(error.what()).size(), 400u);
      }
    }
  std::printf("%d of %d refused\n", n_refused, n_files);
  EXPECT_GT(n_refused, n_files / 2);
}

TEST(Solid, OfAnyShapeIsFilledExactly) {
  fill(read(test::stl_of(prism(40, 3, 4)), ".stl"), 0.8, 1);
  Facets hollow = cube();
  test::add_box(hollow, {1, 1, 1}, {2, 3, 4}, true);
  fill(read(test::off_of(hollow), ".off"), 1, 2);
  const RandomStream streams(5, 0, "bodies");
  std::map<std::string, int> outcomes;
  const int n = test::repetitions(12, 300);
  for (int i = 0; i < n; ++i) {
    RandomStream stream = streams.substream(static_cast<std::uint64_t>(i));
    Facets facets = test::random_hull(stream, static_cast<std::size_t>(stream.uniform(2, 14)));
    if (i % 3 == 1) test::add_cavity(facets, stream.uniform(0.2, 0.5));
    if (i % 3 == 2)
      test::dent(facets,
                 static_cast<std::size_t>(stream.uniform(0, static_cast<double>(facets.polygons.size()))),
                 stream.uniform(0.1, 0.4));
    try {
      const Solid solid = read(test::obj_of(facets), ".obj");
      if (sharpest(solid).angle < 4 * std::numbers::pi / 180) {
        ++outcomes["sharp"];
        continue;
      }
      fill(solid, 1, static_cast<std::uint64_t>(i));
      ++outcomes["filled"];
    } catch (const std::runtime_error& error) {
      const std::string what = error.what();
      const bool is_fine =
          what.find("fiftieth") != std::string::npos || what.find("below 1e-06") != std::string::npos;
      ++outcomes[is_fine ? "fine details" : what];
      EXPECT_TRUE(is_fine) << i << ": " << what;
    }
  }
  for (const auto& [outcome, number] : outcomes) std::printf("%d %s\n", number, outcome.c_str());
  EXPECT_GT(outcomes["filled"], n / 2);
}

/// The area, or the length of a line, of the region of a model's first condition in a sample.
double size_of_region(const input::Model& model, std::uint64_t sample) {
  const auto body = geometry::make_body(model);
  const auto region =
      geometry::condition_region(*geometry::make_body(model.specimen), model.boundaries[0], 0);
  const auto base = geometry::make_mother_points(*body, model.mesh, 7);
  const auto made = geometry::make_realization(*body, base, model.mesh, 7, sample);
  double size = 0;
  std::set<std::pair<int, int>> edges;
  for (const geometry::BoundaryTriangle& triangle : made.boundary) {
    const geometry::FacePart* const part = region.on(triangle.surface);
    if (part == nullptr) continue;
    const auto node = [&](std::size_t i) { return made.nodes[index(triangle.nodes[i % 3])]; };
    if (region.n_dimensions == 2 && part->contains((node(0) + node(1) + node(2)) / 3))
      size += norm(cross(node(1) - node(0), node(2) - node(0))) / 2;
    for (std::size_t i = 0; i < 3; ++i)
      if (region.n_dimensions == 1 && part->contains(node(i)) && part->contains(node(i + 1)) &&
          edges.insert(std::minmax(triangle.nodes[i], triangle.nodes[(i + 1) % 3])).second)
        size += norm(node(i + 1) - node(i));
  }
  return size;
}

TEST(Solid, HasRegionsOnObliqueFacesExactly) {
  const RandomStream streams(12, 0, "regions");
  int n_areas = 0;
  for (int i = 0; i < test::repetitions(4, 60); ++i) {
    RandomStream stream = streams.substream(static_cast<std::uint64_t>(i));
    const Solid solid = read(test::obj_of(test::random_hull(stream, 6)), ".obj");
    input::Model model;
    model.specimen.solid = std::make_shared<const Solid>(solid);
    model.mesh = testing::mesh(1, 1, 0.2);
    model.mesh.min_quality = 0.1;
    input::Boundary& condition = model.boundaries.emplace_back();
    condition.kind = input::BoundaryKind::force;
    const auto faces = named_faces(solid);
    const auto largest = std::ranges::max_element(
        faces, {}, [](const NamedFace& face) { return face.name.starts_with("face") ? face.area : 0; });
    condition.on = largest->name;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (static_cast<int>(axis) != i % 4)
        condition.region[axis] = {largest->centre[axis] - stream.uniform(0.4, 1) * 1e-3,
                                  largest->centre[axis] + stream.uniform(0.4, 1) * 1e-3};
    try {
      const double wanted = area_in(solid, condition.on, condition.on, condition.region);
      for (std::uint64_t sample = 0; sample < 2; ++sample)
        EXPECT_NEAR(size_of_region(model, sample), wanted, 1e-9 * wanted) << i;
      // A line of nodes across the face.
      condition.region = plane::everywhere;
      condition.region[index(i % 3)] = {largest->centre[index(i % 3)], largest->centre[index(i % 3)]};
      const double length = size_of_region(model, 0);
      EXPECT_GT(length, 0) << i;
      EXPECT_NEAR(size_of_region(model, 1), length, 1e-9 * length) << i;
      ++n_areas;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("fiftieth")) << i;
    }
  }
  EXPECT_GT(n_areas, 2);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::solid
