// SPDX-License-Identifier: GPL-3.0-or-later
// Loads on plates of any outline, beside exact solutions.
#include "crackle/dynamics/quasi_static.h"
#include "crackle/geometry/mother_points.h"
#include "crackle/geometry/partition.h"
#include "crackle/geometry/realization.h"
#include "crackle/input/reader.h"
#include "crackle/mechanics/boundary_loads.h"

#include "support/criterion.h"
#include "support/plate_family.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace {

/// A plate with its mesh and its boundary conditions.
struct Plate {
  input::Parameters parameters;
  std::unique_ptr<const geometry::Body> body;
  geometry::Subdomain subdomain;
  parallel::Communicator self{MPI_COMM_SELF};

  Plate(const test::PlateText& text, const std::string& boundaries) {
    std::string whole = text.text();
    const std::string held = "[[boundary]]\non = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n";
    whole.replace(whole.find(held), held.size(), boundaries);
    parameters = input::parse(whole, "plate.toml");
    body = geometry::make_body(parameters.specimen);
    const auto base = geometry::make_mother_points(*body, parameters.mesh, 1);
    const auto mesh = geometry::make_realization(*body, base, parameters.mesh, 1, 0);
    subdomain = geometry::split(mesh, geometry::partition(mesh, 1)).front();
  }

  std::vector<double> displacement() {
    fracture::BreakableBody breakable(subdomain, parameters.material);
    const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
    auto criterion = test::tuler_butcher(parameters.fracture, subdomain);
    const QuasiStaticLoading loading(self, breakable, loads, criterion, 1e-5);
    const auto u = loading.displacement().local();
    return {u.begin(), u.end()};
  }
};

test::PlateText crooked() {
  test::PlateText plate{R"(thickness = "3 mm"
outline = [["0 mm", "0 mm"], ["20 mm", "0 mm"], ["24 mm", "18 mm"], ["0 mm", "15 mm"]])"};
  plate.holes = {R"(center = ["10 mm", "8 mm"]
semi_axes = ["4 mm", "2 mm"]
angle = "30 degree")"};
  plate.notches = {R"(from = ["22 mm", "9 mm"]
to = ["17 mm", "12 mm"]
height = "1 mm"
end = "round")"};
  return plate;
}

// Under the same pressure from all sides a body of any shape only shrinks. It is held where the planes of the
// symmetric solution about a corner are its faces.
TEST(Plates, PressureFromAllSidesShrinksAnyShape) {
  std::string boundaries = R"([[boundary]]
on = "x-min"
fix = ["x"]
[[boundary]]
on = "edge-0"
fix = ["z"]
[[boundary]]
on = "edge-3"
fix = ["y"]
)";
  for (const char* face : {"x-max", "edge-1", "edge-2", "hole-0", "notch-0"})
    boundaries += fmt::format("[[boundary]]\non = \"{}\"\npressure = \"4 MPa\"\n", face);
  Plate plate(crooked(), boundaries);
  const auto u = plate.displacement();
  const auto& material = plate.parameters.material;
  const double strain = -4e6 * (1 - 2 * material.poisson_ratio) / material.youngs_modulus;
  double worst = 0;
  for (std::size_t n = 0; n < plate.subdomain.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i)
      worst = std::max(worst, std::abs(u[3 * n + i] - strain * plate.subdomain.nodes[n][i]));
  std::printf("pressure from all sides: largest displacement error %.1e of the largest displacement\n",
              worst / std::abs(strain * 0.024));
  EXPECT_LT(worst, 1e-8 * std::abs(strain * 0.024));
}

// Resultants of a pin and of a pressure on half of a hole.
TEST(Plates, LoadsOnPartOfAHole) {
  const Plate plate(crooked(), R"([[boundary]]
on = "x-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "hole-0"
region = { z = ["8 mm", "20 mm"] }
force = ["0 N", "3 N", "100 N"]
[[boundary]]
on = "hole-0"
pressure = "1 MPa"
rate = "2 MPa/s"
)");
  const auto loads = mechanics::make_boundary_loads(plate.self, plate.parameters, plate.subdomain);
  ASSERT_EQ(loads.forces.size(), 4u) << "two components of the pin, two of the pressure";
  std::vector<double> force(3 * plate.subdomain.nodes.size(), 0);
  const double time = 0.5;
  loads.add_forces(time, force);
  Vector sum{};
  double outward = 0;  // force on the nodes of the hole away from its centre
  for (std::size_t n = 0; n < plate.subdomain.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i) sum[i] += force[3 * n + i];
  EXPECT_NEAR(sum[0], 0, 1e-12);
  EXPECT_NEAR(sum[1], 3, 1e-9);
  EXPECT_NEAR(sum[2], 100, 1e-9) << "the pressure on the whole hole has no resultant";
  for (std::size_t k = 2; k < 4; ++k) {
    const auto& pattern = loads.forces[k];
    EXPECT_DOUBLE_EQ(pattern.amplitude.at(time), 2e6);
    for (std::size_t i = 0; i < pattern.nodes.size(); ++i) {
      const auto c = static_cast<std::size_t>(pattern.component);
      const double from_centre = plate.subdomain.nodes[index(pattern.nodes[i])][c] - (c == 1 ? 0.010 : 0.008);
      outward += pattern.weight[i] * from_centre;
    }
  }
  // The divergence theorem: twice the volume of the hole.
  double area = 0;
  for (const geometry::Polygon& polygon : plate.body->outline())
    if (plane::signed_area(polygon) < 0) area = -plane::signed_area(polygon);
  EXPECT_NEAR(outward, 2 * area * 0.003, 1e-9 * area);
}

}  // namespace
}  // namespace crackle::dynamics
