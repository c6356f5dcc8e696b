// SPDX-License-Identifier: GPL-3.0-or-later
// How long breaking tetrahedra keep part of their stiffness, and the impulse before they break.
#include "fracture/release_time.h"

#include "dynamics/resolution.h"
#include "fracture/toughness.h"
#include "geometry/body.h"
#include "mechanics/elasticity.h"
#include "parallel/agreement.h"
#include "support/box_mesh.h"
#include "support/job.h"
#include "support/loaded_plate.h"
#include "support/partitions.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

input::Parameters tough_epoxy() {
  input::Parameters parameters;
  parameters.materials = {test::epoxy()};
  parameters.fracture = {.toughness = 93};
  return parameters;
}

/// Edge of the regular tetrahedron with this volume.
double edge(double volume) {
  return std::cbrt(6 * std::sqrt(2.0) * volume);
}

TEST(ReleaseTime, IsTheSpacingOverTheReleaseSpeed) {
  // Two tetrahedra on one triangle, 1 and 3 mm high; the second one's material has a time of its own.
  const std::vector<geometry::Point> nodes{
      {0, 0, 0}, {2e-3, 0, 0}, {0, 2e-3, 0}, {0, 0, 1e-3}, {0, 0, -3e-3}};
  const std::vector<geometry::Tetrahedron> tetrahedra{{0, 1, 2, 3}, {0, 2, 1, 4}};
  const std::vector<std::uint8_t> material{0, 1};
  const double base = 2e-6, small = base * 1e-3 / 3, large = base * 3e-3 / 3;
  auto parameters = tough_epoxy();
  parameters.fracture.release_speed = 500;
  auto times = release_times(parameters, TetrahedronSpan{nodes, tetrahedra});
  const double common = edge((small + large) / 2);
  EXPECT_NEAR(times[0], (3 * common + edge(small)) / 4 / 500, 1e-18);
  EXPECT_NEAR(times[1], (3 * common + edge(large)) / 4 / 500, 1e-18);
  parameters.materials.push_back(parameters.materials[0]);
  parameters.materials[1].release_time = 3e-7;
  times = release_times(parameters, {nodes, tetrahedra, {}, material});
  EXPECT_NEAR(times[0], (3 * common + edge(small)) / 4 / 500, 1e-18);
  EXPECT_EQ(times[1], 3e-7);
}

TEST(ReleaseTime, UsesTheSpacingOfTheThreshold) {
  const auto mesh = test::make_box({.size = {0.003, 0.004, 0.005}, .cells = {3, 4, 5}, .disturbance = 0.2});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  auto parameters = tough_epoxy();
  const BreakableBody body(subdomain, parameters.material());
  const auto times = release_times(self, parameters, body);
  const auto whole = release_times(parameters, TetrahedronSpan{mesh.nodes, mesh.tetrahedra});
  const auto strengths = tetrahedron_strengths(self, parameters, 0, body).nucleation;
  const double speed = 0.7 * mechanics::rayleigh_speed(parameters.material());
  for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) {
    EXPECT_NEAR(toughness_of(parameters, strengths[index(t)], times[t] * speed), 93, 1e-9);
    EXPECT_EQ(times[t], whole[static_cast<std::int32_t>(subdomain.tetrahedron_number[index(t)])]);
  }
  EXPECT_FALSE(times.is_uniform());
}

TEST(ReleaseSpeed, IsThatOfTheRayleighWaveWhereOnlyAToughnessIsGiven) {
  auto parameters = tough_epoxy();
  EXPECT_DOUBLE_EQ(release_speed(parameters, 0), 0.7 * mechanics::rayleigh_speed(parameters.material()));
  parameters.fracture.length = 1e-3;
  EXPECT_GT(release_speed(parameters, 0), 0);
  for (const auto& change : {+[](input::Fracture& f) { f.release_time = 0; },
                             +[](input::Fracture& f) { f.release = input::Release::softening; },
                             +[](input::Fracture& f) { f = {.strength = 35e6}; }}) {
    auto other = tough_epoxy();
    change(other.fracture);
    EXPECT_EQ(release_speed(other, 0), 0);
    other.fracture.release_time = {};
    other.fracture.release_speed = 400;
    EXPECT_EQ(release_speed(other, 0), 400);
    other.materials[0].release_time = 1e-7;
    EXPECT_EQ(release_speed(other, 0), 0);
  }
}

TEST(ReleaseTime, OfLessThanTwoStepsIsRefused) {
  const auto subdomain = test::whole(test::make_box({.cells = {2, 2, 2}}));
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto refuse = [&](std::vector<double> times) {
    times.resize(48, 5e-8);
    refuse_short_releases(self, subdomain, mechanics::TetrahedronField<double>(times), 1e-8);
  };
  EXPECT_NO_THROW(refuse({}));
  EXPECT_NO_THROW(refuse(std::vector<double>(48, 0)));
  try {
    refuse({1.9e-8, 1.5e-8});
    FAIL();
  } catch (const parallel::AgreedError& error) {
    EXPECT_THAT(error.what(), HasSubstr("4.17 % of the tetrahedra"));
    EXPECT_THAT(error.what(), HasSubstr("two time steps of 10 ns, the first in 15 ns: give a lower"));
  }
}

TEST(Impulse, IsInertUnlessGiven) {
  const auto subdomain = test::whole(test::make_box({.size = {0.006, 0.006, 0.006}, .cells = {6, 6, 6}}));
  const parallel::Communicator self(MPI_COMM_SELF);
  const double spacing = 1e-3 * std::cbrt(std::sqrt(2.0));
  const auto impulse_of = [&](const input::Parameters& parameters) {
    const BreakableBody body(subdomain, parameters.material());
    return impulses(self, parameters, body, tetrahedron_strengths(self, parameters, 0, body))[0];
  };
  auto parameters = tough_epoxy();
  const double usual = 0.7 * mechanics::rayleigh_speed(parameters.material());
  const double strength = strength_of(parameters, 93, spacing);
  EXPECT_NEAR(impulse_of(parameters) / (4e-6 * strength * strength * spacing / usual), 1, 1e-9);
  parameters.fracture.release_speed = 300;
  parameters.fracture.exponent = 3;
  EXPECT_NEAR(impulse_of(parameters) / (8e-9 * std::pow(strength, 3) * spacing / 300), 1, 1e-9);
  parameters.fracture.strength = 3 * strength;  // of nucleation: that at cracks counts
  EXPECT_NEAR(impulse_of(parameters) / (8e-9 * std::pow(strength, 3) * spacing / 300), 1, 1e-9);
  parameters.fracture = {.strength = 35e6};
  EXPECT_NEAR(impulse_of(parameters) / (4e-6 * 35e6 * 35e6 * spacing / usual), 1, 1e-9);
  parameters.fracture = {.toughness = 93, .length = 2e-3};
  const double averaged = std::sqrt(
      93 / (toughness_of(parameters, 1, 1) * spacings_per_length(input::Release::element, 0.38) * 2e-3));
  EXPECT_NEAR(impulse_of(parameters) / (4e-6 * averaged * averaged * spacing / usual), 1, 1e-9);
  parameters.fracture.impulse = 1e4;
  EXPECT_EQ(impulse_of(parameters), 1e4);
}

TEST(Dissipation, IsThatOfTheStrips) {
  // Speeds over c_R and energies stored over G of strips of PMMA, without branches, by release speed [m/s].
  constexpr double rayleigh = 921;
  for (const auto& [release, speed, stored] :
       {std::array{1000.0, 0.420, 539.0 / 300}, std::array{635.0, 0.373, 704.0 / 300},
        std::array{300.0, 0.245, 899.0 / 300}, std::array{200.0, 0.201, 1100.0 / 300}})
    EXPECT_NEAR(dissipation_ratio(speed * rayleigh, release, rayleigh), stored, 0.08 * stored) << release;
  for (const double speed : {200.0, 450.0, 800.0}) {
    const double release = release_speed_for(speed, rayleigh);
    EXPECT_NEAR(dissipation_ratio(speed, release, rayleigh), 2, 1e-9);
    EXPECT_NEAR(driven_crack_speed(release, rayleigh), speed, 1e-6);
  }
}

/// The warnings about a toughness alone.
std::vector<std::string> weak_mesh_warnings(const input::Parameters& parameters) {
  auto warnings = dynamics::resolution_warnings(parameters, *geometry::make_body(parameters), 1e-8);
  std::erase_if(warnings, [](const auto& text) { return text.find("with a toughness alone") == text.npos; });
  return warnings;
}

TEST(ToughnessAlone, IsWarnedOfWhereTheMeshIsWeakerThanTheMaterial) {
  // Of the steel plate that is hit, the far edge broke.
  auto parameters = test::job("verification/kalthoff.toml");
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 3e-3;
  EXPECT_THAT(weak_mesh_warnings(parameters), IsEmpty());
  parameters.fracture.strength = 0;
  const auto warnings = weak_mesh_warnings(parameters);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], HasSubstr("tetrahedra of 3 mm hold 1.3"));
  EXPECT_THAT(warnings[0], HasSubstr("a strength of some 2.375 GPa"));
  parameters.time.start = input::Start::quasi_static;  // the slot breaks first
  EXPECT_THAT(weak_mesh_warnings(parameters), IsEmpty());
  EXPECT_THAT(weak_mesh_warnings(test::job("your-own-problem.toml")), IsEmpty());
  EXPECT_THAT(weak_mesh_warnings(test::job("verification/glass-plate.toml")), IsEmpty());
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
