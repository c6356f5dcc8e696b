// SPDX-License-Identifier: GPL-3.0-or-later
// Loads on plates with any outline, against exact solutions.
#include "support/loaded_plate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

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

// Under uniform pressure from all sides a body of any shape only shrinks. It is held on those faces that are
// symmetry planes of the solution about a corner.
TEST(Plates, PressureFromAllSidesShrinksAnyShape) {
  auto text = crooked();
  text.boundaries = R"([[boundary]]
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
    text.boundaries += fmt::format("[[boundary]]\non = \"{}\"\npressure = \"4 MPa\"\n", face);
  test::LoadedPlate plate(text);
  const auto u = plate.displacement();
  const auto& material = plate.parameters.material();
  const double strain = -4e6 * (1 - 2 * material.poisson_ratio) / material.youngs_modulus;
  double worst = 0;
  for (std::size_t n = 0; n < plate.subdomain.nodes.size(); ++n)
    for (std::size_t i = 0; i < 3; ++i)
      worst = std::max(worst, std::abs(u[3 * n + i] - strain * plate.subdomain.nodes[n][i]));
  std::printf("pressure from all sides: largest displacement error %.1e of the largest displacement\n",
              worst / std::abs(strain * 0.024));
  EXPECT_LT(worst, 3e-7 * std::abs(strain * 0.024));
}

// Resultants of a pin and of a pressure on half of a hole.
TEST(Plates, LoadsOnPartOfAHole) {
  auto text = crooked();
  text.boundaries = R"([[boundary]]
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
)";
  const test::LoadedPlate plate(text);
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

/// Mean sigma_zz at nu = 0 of the tetrahedra that touch a point [Pa].
double stress_at(const test::LoadedPlate& plate, const std::vector<double>& u, double y, double z) {
  double sum = 0;
  double volumes = 0;
  for (const mechanics::TetrahedronOperator& t : plate.operators().tetrahedra) {
    if (std::ranges::none_of(t.nodes, [&](std::int32_t n) {
          const geometry::Point& node = plate.subdomain.nodes[index(n)];
          return std::hypot(node[1] - y, node[2] - z) < 1e-9;
        }))
      continue;
    sum += plate.parameters.materials[0].youngs_modulus * mechanics::strain(t, u)[2] * t.volume;
    volumes += t.volume;
  }
  return sum / volumes;
}

// Howland (1930): at a hole of a fifth of the width the stress is 3.14 times the remote stress; Kirsch (1898)
// has 3 for an infinite plate. The means over the tetrahedra at the hole converge linearly with the spacing.
TEST(Plates, StressBesideAHoleIsHowlands) {
  constexpr double howland = 3.14;
  std::vector<double> errors;
  for (const double spacing : {0.4, 0.2, 0.1}) {
    test::PlateText text{R"(size = ["0.4 mm", "10 mm", "24 mm"])"};
    text.holes = {R"(center = ["5 mm", "12 mm"]
radius = "1 mm")"};
    text.section = "5 mm";
    text.mesh = fmt::format(R"(spacing = "0.4 mm"
growth = 0.15
perturbation = 0.2
[[mesh.region]]
y = ["5.9 mm", "6.3 mm"]
z = ["11.8 mm", "12.2 mm"]
spacing = "{} mm")",
                            spacing / 4);
    text.poisson_ratio = 0;
    text.boundaries = test::pulled_plate;
    test::LoadedPlate plate(text);
    const double found = stress_at(plate, plate.displacement(), 6e-3, 12e-3) / 1e6;
    errors.push_back(found / howland - 1);
    std::printf(
        "plate with a hole, spacing %.3f of the radius: %.3f times the stress far away, %+.1f %% of "
        "Howland's "
        "%.2f (%zu tetrahedra)\n",
        spacing / 4, found, 100 * errors.back(), howland, plate.subdomain.tetrahedra.size());
  }
  EXPECT_LT(std::abs(errors[2]), 0.02);
  EXPECT_LT(std::abs(errors[2]), 0.6 * std::abs(errors[1])) << "first order at least";
  EXPECT_LT(std::abs(errors[1]), 0.7 * std::abs(errors[0]));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
