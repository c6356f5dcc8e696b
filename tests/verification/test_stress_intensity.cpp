// SPDX-License-Identifier: GPL-3.0-or-later
// Stress intensity of the centre-notched strip in jobs/verification/notched-strip.toml from the static
// energies of two notch depths, against the handbook (Feddersen), at three spacings.
#include "dynamics/quasi_static.h"
#include "parallel/exact_sum.h"

#include "support/box_mesh.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

constexpr double shorter = 7.5e-3, longer = 8.5e-3;  // notch depths [m]

double strain_energy(double spacing, double depth, std::uint64_t sample) {
  auto parameters = test::job("verification/notched-strip.toml");
  parameters.mesh.notch_spacing = spacing;
  parameters.specimen.notches.front().height = 2 * spacing;
  parameters.specimen.notches.front().depth = depth;
  const auto subdomain = test::whole(test::realization(parameters, sample));
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, parameters.material());
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  auto law = test::tuler_butcher(parameters.fracture, subdomain);
  const QuasiStaticLoading loading(self, body, loads, law, 1e-5);
  return parallel::exact_sum(self, body.strain_energies(loading.displacement().local()));
}

/// K^2 (1 - nu^2) / E, integrated over the notch's growth: the gain of strain energy at constant load.
double handbook_energy() {
  const auto parameters = test::job("verification/notched-strip.toml");
  const double stress = parameters.boundaries.back().value[2];
  const double half_width = parameters.specimen.size[1], thickness = parameters.specimen.size[0];
  const double nu = parameters.materials[0].poisson_ratio;
  constexpr int n = 1000;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double a = shorter + (longer - shorter) * (i + 0.5) / n;
    sum += stress * stress * std::numbers::pi * a / std::cos(std::numbers::pi * a / (2 * half_width));
  }
  return sum * (longer - shorter) / n * thickness * (1 - nu * nu) / parameters.materials[0].youngs_modulus;
}

TEST(StressIntensity, OfANotchedStripIsTheHandbooksAtThreeSpacings) {
  std::vector<double> found;
  for (const double spacing : {1e-3, 0.5e-3, 0.25e-3}) {
    double gain = 0;
    for (std::uint64_t sample = 0; sample < 2; ++sample)
      gain += (strain_energy(spacing, longer, sample) - strain_energy(spacing, shorter, sample)) / 2;
    found.push_back(std::sqrt(gain / handbook_energy()));
    std::printf("spacing %.2f mm at the tip: K over the handbook's %.4f (reference 1)\n", 1e3 * spacing,
                found.back());
  }
  EXPECT_NEAR(found[1], 1, 0.03);
  EXPECT_NEAR(found[2], 1, 0.02);
  EXPECT_LT(std::abs(found[2] - 1), std::abs(found[0] - 1));
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
