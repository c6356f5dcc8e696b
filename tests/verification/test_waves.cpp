// SPDX-License-Identifier: GPL-3.0-or-later
// Plane waves on irregular meshes: P and S waves travel at their speeds, with a second-order error in space.
#include "support/effort.h"
#include "support/elastic_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

constexpr double length = 0.012;

/// A standing wave u_i = A cos(pi z / L) over one period of its exact frequency.
///
/// At the end of the period the wave is at a turning point, where a frequency error appears in second order
/// only; hence the error is evaluated over the whole period.
/// @param axis of the motion: 2 for the P wave, 0 for the S wave
/// @return root mean square over 16 moments of the mass norm of the error, relative to that of the amplitude
double error_of_standing_wave(int axis, double spacing, std::uint64_t sample) {
  input::Parameters parameters;
  parameters.specimen.size = {0.002, 0.002, length};
  parameters.materials[0] = test::epoxy();
  // Walls that let the plane wave pass along them.
  for (const Face face : {Face::y_min, Face::y_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  for (const Face face : {Face::x_min, Face::x_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {axis == 2, false, axis == 0}));
  test::ElasticMotion motion(test::irregular_box(parameters.specimen.size, spacing, sample), parameters);
  const mechanics::IsotropicElasticity elasticity(parameters.material());
  const double modulus = axis == 2 ? elasticity.lambda + 2 * elasticity.mu : elasticity.mu;
  const double period = 2 * length / std::sqrt(modulus / parameters.materials[0].density);

  const double amplitude = 1e-6;
  const auto component = static_cast<std::size_t>(axis);
  const auto wave = [&](std::size_t n) {
    return amplitude * std::cos(std::numbers::pi * motion.subdomain().nodes[n][2] / length);
  };
  double whole = 0;
  for (std::size_t n = 0; n < motion.n_nodes(); ++n) {
    motion.state().displacement.local()[3 * n + component] = wave(n);
    whole += motion.mass(n) * wave(n) * wave(n);
  }
  motion.start(period);
  constexpr int n_moments = 16;
  const double interval = period / n_moments;
  const auto n_steps = static_cast<std::int64_t>(std::ceil(interval / (0.5 * motion.stable_step())));
  double error = 0;
  for (int moment = 1; moment <= n_moments; ++moment) {
    motion.advance(n_steps, interval / static_cast<double>(n_steps));
    const double phase = std::cos(2 * std::numbers::pi * moment / n_moments);
    for (std::size_t n = 0; n < motion.n_nodes(); ++n) {
      for (std::size_t i = 0; i < 3; ++i) {
        const double difference = motion.displacement(n, i) - (i == component ? wave(n) * phase : 0);
        error += motion.mass(n) * difference * difference;
      }
    }
  }
  return std::sqrt(error / n_moments / whole);
}

class PlaneWave : public ::testing::TestWithParam<int> {};

TEST_P(PlaneWave, ConvergesWithOrderTwoInSpace) {
  const char* name = GetParam() == 2 ? "P" : "S";
  constexpr std::array spacings{1e-3, 0.7e-3, 0.5e-3, 0.35e-3, 0.25e-3};
  const int n_samples = test::repetitions(1, 4);
  std::vector<double> errors;
  const auto order = [&](std::size_t coarse, std::size_t fine) {
    return std::log(errors[coarse] / errors[fine]) / std::log(spacings[coarse] / spacings[fine]);
  };
  for (const double spacing : spacings) {
    double sum = 0, least = INFINITY, greatest = 0;
    for (int sample = 0; sample < n_samples; ++sample) {
      const double error = error_of_standing_wave(GetParam(), spacing, static_cast<std::uint64_t>(sample));
      sum += error;
      least = std::min(least, error);
      greatest = std::max(greatest, error);
    }
    errors.push_back(sum / n_samples);
    std::printf("%s wave, spacing %.2f mm (%.0f in the wavelength): error %.2e, %.2e to %.2e over %d samples",
                name, 1e3 * spacing, 2 * length / spacing, errors.back(), least, greatest, n_samples);
    if (errors.size() > 1) std::printf(", order %.2f", order(errors.size() - 2, errors.size() - 1));
    std::printf("\n");
  }
  std::printf("%s wave: from 0.5 to 0.25 mm order %.2f (reference 2)\n", name, order(2, 4));
  EXPECT_NEAR(order(2, 4), 2, 0.2);
  EXPECT_LT(errors.back(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Waves, PlaneWave, ::testing::Values(2, 0),
                         [](const auto& info) { return info.param == 2 ? "P" : "S"; });

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
