// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies of two materials, on the program's meshes of their boundaries, against exact solutions.
#include "dynamics/moving_body.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "dynamics/stable_step.h"
#include "fracture/material_field.h"
#include "fracture/toughness.h"
#include "geometry/point.h"

#include "support/box_mesh.h"
#include "support/job.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

/// A box of a matrix and an insert.
input::Parameters two_materials(const std::string& size, const std::string& region, const std::string& mesh,
                                const input::Material& matrix, const input::Material& insert,
                                const std::string& boundaries, const std::string& start = "quasi-static") {
  const auto material = [](const char* name, const input::Material& one) {
    return fmt::format(R"([[material]]
name = "{}"
youngs_modulus = "{} Pa"
poisson_ratio = {}
density = "{} kg/m^3"
)",
                       name, one.youngs_modulus, one.poisson_ratio, one.density);
  };
  return input::parse(fmt::format(R"([ensemble]
samples = 1
seed = 3
[specimen]
size = {}
[[specimen.region]]
material = "insert"
{}
[mesh]
{}
[fracture]
strength = "35 MPa"
impulse = "1e-8 MPa^2 s"
[time]
start = "{}"
duration = "100 us"
[sections]
z = ["1 mm"]
{}
{}{})",
                                  size, region, mesh, start, boundaries, material("matrix", matrix),
                                  material("insert", insert)),
                      "materials.toml");
}

/// A body that does not break, with its loads.
struct Composite {
  explicit Composite(const input::Parameters& input)
      : parameters(input),
        subdomain(test::whole(test::realization(parameters))),
        body(subdomain, fracture::make_material_field(parameters, 0, fracture::span_of(subdomain))),
        loads(mechanics::make_boundary_loads(self, parameters, subdomain)),
        law(test::unbreakable(subdomain)) {}

  std::vector<double> equilibrium() {
    const QuasiStaticLoading loading(self, body, loads, law, 1e-5);
    const auto u = loading.displacement().local();
    return {u.begin(), u.end()};
  }

  parallel::Communicator self{MPI_COMM_SELF};
  input::Parameters parameters;
  geometry::Subdomain subdomain;
  fracture::BreakableBody body;
  mechanics::Conditions loads;
  fracture::FractureLaw law;
};

const std::string rollers = R"([[boundary]]
on = "x-min"
fix = ["x"]
[[boundary]]
on = "y-min"
fix = ["y"]
[[boundary]]
on = "z-min"
fix = ["z"]
)";
const std::string symmetric_pull = rollers + R"([[boundary]]
on = "z-max"
traction = ["0 MPa", "0 MPa", "1 MPa"]
)";

TEST(TwoMaterials, InSeriesStretchAsTheirModuliSay) {
  Composite bar(two_materials(R"(["2 mm", "3 mm", "12 mm"])", R"(z = ["5 mm", "12 mm"])",
                              "spacing = \"1 mm\"", {3e9, 0, 1000}, {60e9, 0, 1000}, symmetric_pull));
  const auto u = bar.equilibrium();
  double worst = 0;
  for (std::size_t n = 0; n < bar.subdomain.nodes.size(); ++n) {
    const double z = bar.subdomain.nodes[n][2];
    const double exact = 1e6 * (std::min(z, 0.005) / 3e9 + std::max(z - 0.005, 0.0) / 60e9);
    worst = std::max(worst, std::abs(u[3 * n + 2] - exact));
  }
  const double longest = 1e6 * (0.005 / 3e9 + 0.007 / 60e9);
  std::printf("two materials in series: largest displacement error %.1e of the largest displacement\n",
              worst / longest);
  EXPECT_LT(worst, 1e-8 * longest) << "linear tetrahedra are exact where they conform to the boundary";
}

/// A smooth pulse sent into the matrix; what comes back and what goes on are separate waves, so the
/// momentum of each part of the bar is that of its wave.
void expect_reflection(const input::Material& matrix, const input::Material& insert) {
  const double length = 0.04;
  const double c1 = std::sqrt(matrix.youngs_modulus / matrix.density);
  const double c2 = std::sqrt(insert.youngs_modulus / insert.density);
  const double duration = 0.4 * length / c1;
  std::string history;
  for (int i = 0; i <= 40; ++i)
    history += fmt::format("[\"{} s\", {}], ", duration * i / 40, std::pow(std::sin(M_PI * i / 40), 2));
  Composite bar(two_materials(
      R"(["3 mm", "3 mm", "120 mm"])", R"(z = ["40 mm", "120 mm"])", "spacing = \"1 mm\"", matrix, insert,
      fmt::format("[[boundary]]\non = \"z-min\"\npressure = \"1 MPa\"\nhistory = [{}]\n", history), "rest"));
  const MotionContext context{&bar.self, &bar.body, &bar.loads, &bar.law};
  MotionState state{parallel::NodeField(bar.self, bar.subdomain.layout),
                    parallel::NodeField(bar.self, bar.subdomain.layout)};
  // The reflected pulse has left the boundary, and none has come to an end.
  const double end = 1.6 * length / c1;
  ASSERT_LT(end, 2 * length / c1);
  ASSERT_LT((end - length / c1) * c2, 0.08);
  const auto motion = make_fixed_point_motion(context, input::Precision::double_, 0, end, state);
  const auto& map = splitting(input::Integrator::verlet);
  const double stable = map.stability_limit /
                        largest_frequency(bar.self, bar.subdomain, bar.body.operators(), bar.body.force());
  const auto n_steps = static_cast<int>(std::ceil(end / (0.8 * stable)));
  for (int i = 0; i < n_steps; ++i) motion->step(map.even, end / n_steps, end * i / n_steps);
  motion->read(state);
  double back = 0, on = 0;
  for (std::size_t n = 0; n < bar.subdomain.nodes.size(); ++n) {
    const double momentum = bar.body.operators().node_mass[n] * state.velocity.local()[3 * n + 2];
    (bar.subdomain.nodes[n][2] < length ? back : on) += momentum;
  }
  const double sent = 1e6 * 9e-6 * duration / 2;
  const double z1 = matrix.density * c1, z2 = insert.density * c2;
  const double reflected = -back / sent, expected = (z2 - z1) / (z2 + z1);
  std::printf("impedances %.2g and %.2g MPa s/m: reflected %.4f, exact %.4f; transmitted %.4f, exact %.4f\n",
              1e-6 * z1, 1e-6 * z2, reflected, expected, on / sent, 1 + expected);
  EXPECT_NEAR(reflected, expected, 0.01);
  EXPECT_NEAR(on / sent, 1 + expected, 0.01);
}

TEST(TwoMaterials, ReflectWavesByTheirImpedances) {
  expect_reflection({3300e6, 0, 1180}, {70e9, 0, 2500});
  expect_reflection({70e9, 0, 2500}, {60e9, 0, 900});
}

/// Mean stress of the insert, a disc in a wide plate in plane strain under tension along z.
void expect_inclusion(double ratio) {
  const input::Material matrix{3e9, 0.3, 1000}, insert{ratio * 3e9, 0.2, 1000};
  Composite plate(two_materials(
      R"(["0.8 mm", "24 mm", "24 mm"])", "center = [\"12 mm\", \"12 mm\"]\nradius = \"1.2 mm\"",
      "spacing = \"0.8 mm\"\ngrowth = 0.2\n[[mesh.region]]\ny = [\"10.5 mm\", \"13.5 mm\"]\nz = [\"10.5 "
      "mm\", "
      "\"13.5 "
      "mm\"]\nspacing = \"0.25 mm\"",
      matrix, insert,
      "[[boundary]]\non = \"x-min\"\nfix = [\"x\"]\n[[boundary]]\non = \"x-max\"\nfix = [\"x\"]\n"
      "[[boundary]]\non = \"y-min\"\nregion = { z = [\"12 mm\", \"12 mm\"] }\nfix = [\"z\"]\n"
      "[[boundary]]\non = \"z-min\"\nregion = { y = [\"12 mm\", \"12 mm\"] }\nfix = [\"y\"]\n"
      "[[boundary]]\non = \"y-max\"\nregion = { z = [\"12 mm\", \"12 mm\"] }\nfix = [\"z\"]\n"
      "[[boundary]]\non = \"z-max\"\ntraction = [\"0 MPa\", \"0 MPa\", \"1 MPa\"]\n"
      "[[boundary]]\non = \"z-min\"\ntraction = [\"0 MPa\", \"0 MPa\", \"-1 MPa\"]\n"));
  const auto u = plate.equilibrium();
  double volume = 0, along = 0, across = 0;
  for (std::int32_t t = 0; t < plate.subdomain.n_tetrahedra(); ++t) {
    if (plate.subdomain.material[index(t)] != 1) continue;
    const double v = plate.body.operators().tetrahedra[index(t)].volume;
    const auto stress = plate.body.stress(t, u);
    volume += v;
    along += v * stress[2];
    across += v * stress[1];
  }
  // Goodier (1933) in plane strain; the mean and the difference of the stresses, uniform in the disc.
  const double mu = matrix.youngs_modulus / (2 * (1 + matrix.poisson_ratio));
  const double mu1 = insert.youngs_modulus / (2 * (1 + insert.poisson_ratio));
  const double kappa = 3 - 4 * matrix.poisson_ratio, kappa1 = 3 - 4 * insert.poisson_ratio;
  const double mean = 0.5e6 * mu1 * (kappa + 1) / (2 * mu1 + mu * (kappa1 - 1));
  const double half = 0.5e6 * mu1 * (kappa + 1) / (mu + kappa * mu1);
  std::printf(
      "disc %g times as stiff: stress %.4f along, %.4f across; by Goodier %.4f, %.4f (unit: the remote "
      "one)\n",
      ratio, 1e-6 * along / volume, 1e-6 * across / volume, 1e-6 * (mean + half), 1e-6 * (mean - half));
  EXPECT_NEAR(along / volume, mean + half, 0.03 * (mean + half));
  EXPECT_NEAR(across / volume, mean - half, 0.03 * (mean + half));
}

TEST(TwoMaterials, AStiffAndASoftDiscHaveGoodiersStress) {
  expect_inclusion(20);
  expect_inclusion(0.1);
}

TEST(TwoMaterials, HaveTheirStrengthsAndThatOfTheirInterface) {
  auto parameters = two_materials(R"(["2 mm", "6 mm", "12 mm"])", R"(z = ["5 mm", "12 mm"])",
                                  "spacing = \"1 mm\"", {3e9, 0.3, 1000}, {60e9, 0.2, 2000}, symmetric_pull);
  parameters.materials[1].strength = 80e6;
  parameters.interfaces = {{{"insert", "matrix"}, 10e6, 0}};
  Composite bar(parameters);
  const auto strengths = fracture::tetrahedron_strengths(bar.self, parameters, 0, bar.body).nucleation;
  std::array<int, 3> n{};
  for (std::size_t t = 0; t < strengths.size(); ++t) {
    const auto& corners = bar.subdomain.tetrahedra[t];
    const bool touches = std::ranges::any_of(corners, [&](std::int32_t node) {
      return std::abs(bar.subdomain.nodes[index(node)][2] - 0.005) < 1e-9;
    });
    const bool is_insert = geometry::centroid(bar.subdomain.nodes, corners)[2] > 0.005;
    ASSERT_EQ(strengths[t], touches ? 10e6 : is_insert ? 80e6 : 35e6);
    ++n[touches ? 2 : is_insert ? 1 : 0];
  }
  std::printf("%d tetrahedra of the matrix, %d of the insert, %d at the interface\n", n[0], n[1], n[2]);
  EXPECT_GT(std::ranges::min(n), 50);
}

/// Two bars end to end, bonded less well than either holds: in uniform tension the bond breaks at its
/// strength, over whatever length the stress is averaged.
TEST(TwoMaterials, BondedLessWellBreakAtTheStrengthOfTheBond) {
  const std::string pull = rollers + R"([[boundary]]
on = "z-max"
force = ["0 N", "0 N", "0 N"]
rate = ["0 N/s", "0 N/s", "10 N/s"]
)";
  const parallel::Communicator self(MPI_COMM_SELF);
  for (const auto& [length, strength] : {std::pair{1.2e-3, 12e6}, {2.4e-3, 12e6}, {1.2e-3, 3e6}}) {
    auto parameters = two_materials(R"(["2 mm", "2 mm", "20 mm"])", R"(z = ["10 mm", "20 mm"])",
                                    "spacing = \"0.6 mm\"", {10e9, 0.2, 2000}, {10e9, 0.2, 2000}, pull);
    parameters.materials[0].strength = 30e6;
    parameters.materials[1].strength = 40e6;
    parameters.interfaces = {{{"insert", "matrix"}, strength, 0}};
    parameters.fracture.length = length;
    const double exact = strength * 2e-3 * 2e-3;
    const auto result =
        run_sample(self, parameters, parameters.output, test::whole(test::realization(parameters)), {});
    std::printf(
        "a bond of %.0f MPa, stress averaged over %.1f mm: first break at %.3f N, peak load %.3f N, exact "
        "%.0f N\n",
        1e-6 * strength, 1e3 * length, result.first_break_load, result.loads.peak_load, exact);
    EXPECT_NEAR(result.first_break_load, exact, 1e-4 * exact);
    EXPECT_NEAR(result.loads.peak_load, exact, 0.02 * exact);
    EXPECT_EQ(result.outcome, Outcome::separated);
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
