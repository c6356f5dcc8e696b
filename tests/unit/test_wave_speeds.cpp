// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/sample_run.h"
#include "fracture/material_field.h"
#include "mechanics/conditions.h"
#include "mechanics/elasticity.h"

#include "support/box_mesh.h"
#include "support/job.h"
#include "support/plate_family.h"

#include <gtest/gtest.h>

#include <cmath>

namespace crackle::mechanics {
namespace CRACKLE_TEST_FILE {

TEST(WaveSpeeds, AreThoseOfTheTextbook) {
  // Steel, common table values: 5.9 and 3.2 km/s, Rayleigh wave at 0.926 of the latter.
  const input::Material steel{210e9, 0.29, 7850};
  EXPECT_NEAR(dilatational_speed(steel), 5920, 10);
  EXPECT_NEAR(shear_speed(steel), 3220, 10);
  EXPECT_NEAR(rayleigh_speed(steel) / shear_speed(steel), 0.926, 0.001);
  for (const double nu : {0.0, 0.25, 0.38, 0.49}) {
    const input::Material material{3.3e9, nu, 1180};
    EXPECT_NEAR(std::pow(dilatational_speed(material) / shear_speed(material), 2),
                2 * (1 - nu) / (1 - 2 * nu), 1e-9);
  }
}

TEST(WaveSpeeds, ArrestWindowIsABarWavesWayAlongTheLongestExtent) {
  input::Parameters parameters;
  parameters.specimen.size = {0.14, 0.005, 0.0245};
  parameters.materials[0] = {3.3e9, 0.38, 1180};
  const double speed = bar_speed(IsotropicElasticity(parameters.materials[0]), 1180);
  EXPECT_DOUBLE_EQ(dynamics::arrest_window(parameters.time, parameters.specimen.size, {speed, 0}),
                   0.14 / std::sqrt(3.3e9 / 1180));
  parameters.time.arrest = 3e-6;
  EXPECT_EQ(dynamics::arrest_window(parameters.time, parameters.specimen.size, {speed, 0}), 3e-6);
}

TEST(WaveSpeeds, OfARasterOfTwosAreThoseOfTwiceTheModulus) {
  test::PlateText plate{R"(size = ["2 mm", "10 mm", "20 mm"])"};
  plate.section = "5 mm";
  input::Parameters mapped = input::parse(plate.text(), "plate.toml");
  mapped.boundaries = {test::boundary(plane::Face::z_min, input::BoundaryKind::absorbing)};
  input::Parameters stiff = mapped;
  mapped.map.emplace().of = input::MapOf::stiffness;
  stiff.materials[0].youngs_modulus *= 2;
  geometry::Subdomain subdomain = test::whole(test::realization(stiff));
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto body_of = [&](const input::Parameters& parameters, const geometry::Subdomain& part) {
    return fracture::BreakableBody(part,
                                   fracture::make_material_field(parameters, 0, fracture::span_of(part)));
  };
  geometry::Subdomain of_twos = subdomain;
  of_twos.map_factor.assign(of_twos.tetrahedra.size(), 2);
  const auto body = body_of(stiff, subdomain), body_of_twos = body_of(mapped, of_twos);
  const auto waves = fracture::slowest_waves(self, stiff, body);
  const auto waves_of_twos = fracture::slowest_waves(self, mapped, body_of_twos);
  std::printf("bar waves %.2f and %.2f m/s\n", waves.bar, waves_of_twos.bar);
  EXPECT_NEAR(waves.bar, std::sqrt(6.6e9 / 1180), 1e-9);
  EXPECT_NEAR(waves_of_twos.bar, waves.bar, 1e-12 * waves.bar);
  EXPECT_NEAR(waves_of_twos.dilatational, waves.dilatational, 1e-12 * waves.dilatational);
  EXPECT_NEAR(dynamics::arrest_window(mapped.time, mapped.specimen.size, waves_of_twos),
              dynamics::arrest_window(stiff.time, stiff.specimen.size, waves), 1e-18);
  const auto loads = make_boundary_loads(self, stiff, subdomain, body.material());
  const auto loads_of_twos = make_boundary_loads(self, mapped, of_twos, body_of_twos.material());
  ASSERT_EQ(loads.absorbers.size(), 1U);
  ASSERT_EQ(loads.absorbers[0].nodes, loads_of_twos.absorbers.at(0).nodes);
  EXPECT_EQ(loads.absorbers[0].impedance, loads_of_twos.absorbers[0].impedance);
  EXPECT_GT(loads.absorbers[0].impedance[0][2], 0);
}

TEST(WaveSpeeds, OfTwoMaterialsAreThoseOfTheSlowerOne) {
  test::PlateText plate{R"(size = ["2 mm", "10 mm", "20 mm"])"};
  plate.section = "5 mm";
  input::Parameters parameters = input::parse(plate.text(), "plate.toml");
  geometry::Subdomain subdomain = test::whole(test::realization(parameters));
  parameters.materials.push_back(parameters.materials[0]);
  parameters.materials[1].youngs_modulus *= 16;
  // Stiff but for one tetrahedron, then the half of the soft one with four times its modulus.
  subdomain.material.assign(subdomain.tetrahedra.size(), 1);
  subdomain.material[7] = 0;
  const parallel::Communicator self(MPI_COMM_SELF);
  const fracture::BreakableBody body(subdomain, material_field(parameters.materials, subdomain.material));
  const double bar = std::sqrt(3.3e9 / 1180);
  EXPECT_NEAR(fracture::slowest_waves(self, parameters, body).bar, bar, 1e-12 * bar);
  parameters.materials.resize(1);
  subdomain.material.clear();
  std::vector<IsotropicElasticity> elasticity(subdomain.tetrahedra.size(),
                                              IsotropicElasticity(parameters.materials[0]));
  double stiff_volume = 0, volume = 0;
  for (std::size_t t = 0; t < elasticity.size(); ++t) {
    const double own = body.operators().tetrahedra[t].volume;
    volume += own;
    if (t % 2 == 0) continue;
    elasticity[t] = IsotropicElasticity(4 * 3.3e9, 0.38);
    stiff_volume += own;
  }
  const fracture::BreakableBody graded(subdomain, {ElasticityField(std::move(elasticity)), 1180});
  // A wave takes half as long where the stiffness is four times as high.
  EXPECT_NEAR(fracture::slowest_waves(self, parameters, graded).bar, bar / (1 - stiff_volume / volume / 2),
              1e-9 * bar);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::mechanics
