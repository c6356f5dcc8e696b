// SPDX-License-Identifier: GPL-3.0-or-later
// Stress intensities of plates: a compact tension specimen by its energy, inclined slots by the interaction
// integral.
#include "parallel/exact_sum.h"

#include "support/effort.h"
#include "support/loaded_plate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using std::numbers::pi;

constexpr double width = 40e-3, thickness = 0.8e-3, load = 100;  // of the compact tension specimen [m, m, N]

/// With a slot of `depth` [m] from the load line, according to ASTM E399.
double energy_of_compact_tension(double spacing, double depth) {
  test::PlateText text{R"(thickness = "0.8 mm"
outline = [["0 mm", "0 mm"], ["50 mm", "0 mm"], ["50 mm", "48 mm"], ["0 mm", "48 mm"]])"};
  for (const double centre : {13, 35})
    text.holes.push_back(fmt::format(R"(center = ["10 mm", "{} mm"]
radius = "5 mm")",
                                     centre));
  text.notches = {fmt::format(R"(from = ["0 mm", "24 mm"]
to = ["{} mm", "24 mm"]
height = "{} mm")",
                              10 + 1e3 * depth, 2e3 * spacing)};
  text.mesh = fmt::format(R"(spacing = "{} mm"
notch_spacing = "{} mm"
growth = 0.15
perturbation = 0.1
symmetry = "none")",
                          1e3 * std::min(4 * spacing, thickness), 1e3 * spacing);
  text.section = "40 mm";
  text.poisson_ratio = 0;
  text.boundaries = R"([[boundary]]
on = "hole-0"
region = { z = ["8 mm", "9.5 mm"] }
fix = ["x", "y", "z"]
[[boundary]]
on = "hole-1"
region = { z = ["38.5 mm", "40 mm"] }
force = ["0 N", "0 N", "100 N"]
)";
  test::LoadedPlate plate(text);
  const auto displacement = plate.displacement();
  const fracture::BreakableBody body(plate.subdomain, plate.parameters.material());
  return parallel::exact_sum(plate.self, body.strain_energies(displacement));
}

/// Stress intensity by Srawley (1976), the formula of ASTM E399 [Pa sqrt(m)].
double srawley(double depth) {
  const double a = depth / width;
  return load / (thickness * std::sqrt(width)) * (2 + a) / std::pow(1 - a, 1.5) *
         (0.886 + a * (4.64 + a * (-13.32 + a * (14.72 - a * 5.6))));
}

TEST(PlateStressIntensity, OfACompactTensionSpecimenIsSrawleys) {
  constexpr double shorter = 19e-3, longer = 21e-3, youngs_modulus = 3300e6;
  constexpr int n = 200;
  double expected = 0;
  for (int i = 0; i < n; ++i) {
    const double k = srawley(shorter + (longer - shorter) * (i + 0.5) / n);
    expected += k * k / youngs_modulus * thickness * (longer - shorter) / n;
  }
  std::vector<double> found;
  const std::vector<double> coarse{0.4e-3, 0.2e-3}, all{0.4e-3, 0.2e-3, 0.1e-3};
  for (const double spacing : test::is_full() ? all : coarse) {
    const double gain =
        energy_of_compact_tension(spacing, longer) - energy_of_compact_tension(spacing, shorter);
    found.push_back(std::sqrt(gain / expected));
    std::printf("compact tension, spacing %.2f mm at the tip: K over Srawley's %.4f\n", 1e3 * spacing,
                found.back());
  }
  const double at_zero = 2 * found.back() - found[found.size() - 2];
  std::printf("compact tension, extrapolated to spacing zero: K over Srawley's %.4f\n", at_zero);
  EXPECT_NEAR(at_zero, 1, 0.01);
  EXPECT_NEAR(found[0], 1, 0.02);
}

/// In the plane of the plate: component i, derivative along j.
using Gradient = std::array<std::array<double, 2>, 2>;

/// Displacement near a crack tip at the origin, where the first axis points ahead, for K_I = 1 or K_II = 1 at
/// nu = 0 (Williams 1957) [m].
std::array<double, 2> near_tip(int mode, double youngs_modulus, double x, double y) {
  const double half = std::atan2(y, x) / 2;
  const double c = std::cos(half), s = std::sin(half);
  constexpr double kappa = 3;
  const double factor = std::sqrt(std::hypot(x, y) / (2 * pi)) / youngs_modulus;
  if (mode == 0) return {factor * c * (kappa - 1 + 2 * s * s), factor * s * (kappa + 1 - 2 * c * c)};
  return {factor * s * (kappa + 1 + 2 * c * c), -factor * c * (kappa - 1 - 2 * s * s)};
}

Gradient near_tip_gradient(int mode, double youngs_modulus, double x, double y) {
  const double step = 1e-5 * std::hypot(x, y);
  Gradient result{};
  for (std::size_t j = 0; j < 2; ++j) {
    const double dx = j == 0 ? step : 0, dy = j == 0 ? 0 : step;
    const auto above = near_tip(mode, youngs_modulus, x + dx, y + dy);
    const auto below = near_tip(mode, youngs_modulus, x - dx, y - dy);
    for (std::size_t i = 0; i < 2; ++i) result[i][j] = (above[i] - below[i]) / (2 * step);
  }
  return result;
}

/// At nu = 0.
Gradient stress_of(const Gradient& gradient, double youngs_modulus) {
  Gradient result{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j) result[i][j] = youngs_modulus * (gradient[i][j] + gradient[j][i]) / 2;
  return result;
}

/// K_I and K_II at a slot's tip by the interaction integral over a ring around it (Yau, Wang and Corten 1980)
/// [Pa sqrt(m)]; the slot runs towards (cos angle, sin angle).
std::array<double, 2> stress_intensities(const test::LoadedPlate& plate,
                                         const std::vector<double>& displacement,
                                         const std::array<double, 2>& tip, double angle, double inner,
                                         double outer) {
  const double youngs_modulus = plate.parameters.materials[0].youngs_modulus;
  const double c = std::cos(angle), s = std::sin(angle);
  const auto turned = [&](double y, double z) { return std::array{c * y + s * z, c * z - s * y}; };
  std::array<double, 2> result{};
  for (const mechanics::TetrahedronOperator& t : plate.operators().tetrahedra) {
    std::array<double, 4> weight{};
    std::array<double, 2> centre{};
    for (std::size_t a = 0; a < 4; ++a) {
      const auto& node = plate.subdomain.nodes[index(t.nodes[a])];
      const auto place = turned(node[1] - tip[0], node[2] - tip[1]);
      weight[a] = std::clamp((outer - std::hypot(place[0], place[1])) / (outer - inner), 0.0, 1.0);
      for (std::size_t i = 0; i < 2; ++i) centre[i] += place[i] / 4;
    }
    if (std::ranges::all_of(weight, [&](double w) { return w == weight[0]; })) continue;
    Gradient gradient{};
    std::array<double, 2> slope{};  // of the weight
    for (std::size_t a = 0; a < 4; ++a) {
      const double* u = &displacement[3 * index(t.nodes[a])];
      const auto moved = turned(u[1], u[2]);
      const auto shape = turned(t.gradient[a][1], t.gradient[a][2]);
      for (std::size_t j = 0; j < 2; ++j) {
        slope[j] += shape[j] * weight[a];
        for (std::size_t i = 0; i < 2; ++i) gradient[i][j] += shape[j] * moved[i];
      }
    }
    const Gradient stress = stress_of(gradient, youngs_modulus);
    for (int mode = 0; mode < 2; ++mode) {
      const Gradient other = near_tip_gradient(mode, youngs_modulus, centre[0], centre[1]);
      const Gradient other_stress = stress_of(other, youngs_modulus);
      double energy = 0;
      double sum = 0;
      for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t j = 0; j < 2; ++j) {
          energy += stress[i][j] * other[i][j];
          sum += (stress[i][j] * other[i][0] + other_stress[i][j] * gradient[i][0]) * slope[j];
        }
      result[index(mode)] += youngs_modulus / 2 * (sum - energy * slope[0]) * t.volume;
    }
  }
  const double plate_thickness = plate.parameters.specimen.size[0];
  return {result[0] / plate_thickness, result[1] / plate_thickness};
}

TEST(PlateStressIntensity, OfAnInclinedSlotIsThatOfACrack) {
  constexpr double half_length = 2, middle = 20;  // of the slot and of the plate [mm]
  for (const double degrees : {0.0, 15.0, 30.0, 45.0, 60.0}) {
    const double angle = degrees * pi / 180;
    const double c = std::cos(angle), s = std::sin(angle);
    const double y = half_length * c, z = half_length * s;
    test::PlateText text{R"(size = ["0.8 mm", "40 mm", "40 mm"])"};
    text.notches = {fmt::format(R"(from = ["{} mm", "{} mm"]
to = ["{} mm", "{} mm"]
height = "0.1 mm")",
                                middle - y, middle - z, middle + y, middle + z)};
    text.mesh = R"(spacing = "0.8 mm"
notch_spacing = "0.1 mm"
growth = 0.1
perturbation = 0.1
symmetry = "none")";
    text.poisson_ratio = 0;
    text.boundaries = test::pulled_plate;
    test::LoadedPlate plate(text);
    const std::array tip{1e-3 * (middle + y), 1e-3 * (middle + z)};
    auto found = stress_intensities(plate, plate.displacement(), tip, angle, 0.5e-3, 1e-3);
    for (double& k : found) k /= 1e6 * std::sqrt(pi * 1e-3 * half_length);
    std::printf(
        "slot inclined by %.0f degrees: K_I %.4f, K_II %.4f of sigma sqrt(pi a); a crack in an endless plate "
        "%.4f, %.4f\n",
        degrees, found[0], found[1], c * c, s * c);
    EXPECT_NEAR(found[0], c * c, 0.02 * c * c);
    EXPECT_NEAR(found[1], s * c, std::max(0.02 * s * c, 0.002));
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
