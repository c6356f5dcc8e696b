// SPDX-License-Identifier: GPL-3.0-or-later
// The static and a transient solution compared with CalculiX on the same mesh; its linear tetrahedron C3D4
// has the same stiffness as PDS-FEM.
#include "dynamics/moving_body.h"
#include "dynamics/quasi_static.h"
#include "dynamics/stable_step.h"
#include "fracture/material_field.h"
#include "geometry/mother_points.h"

#include "geometry/body.h"
#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/temporary_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;

input::Parameters notched_plate() {
  auto parameters = test::brittle({0.003, 0.012, 0.03});
  parameters.specimen.notches = {{Face::y_min, 0.013, 0.003, 0.001}, {Face::y_max, 0.017, 0.003, 0.001}};
  parameters.mesh.spacing = 0.0015;
  parameters.mesh.notch_spacing = test::is_full() ? 0.0005 : 0.001;
  parameters.mesh.growth = 0.1;
  parameters.mesh.perturbation = 0.2;
  parameters.mesh.min_quality = 0.2;
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {20, -30, 100}));
  return parameters;
}

/// Writes the problem in CalculiX's input format, in mm, N, MPa and tonnes, which are easier to read;
/// CalculiX's output has few digits in any unit.
/// @param step the lines after *STEP that define the analysis
void write_input(const std::filesystem::path& file, const input::Parameters& parameters,
                 const geometry::Realization& mesh, std::span<const std::uint8_t> material_of,
                 const std::vector<double>& nodal_force, const std::string& step, const std::string& output) {
  std::ofstream out(file);
  out << "*NODE, NSET=ALL\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const auto& p = mesh.nodes[n];
    out << fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", n + 1, 1e3 * p[0], 1e3 * p[1], 1e3 * p[2]);
  }
  for (std::size_t m = 0; m < parameters.materials.size(); ++m) {
    const input::Material& material = parameters.materials[m];
    out << fmt::format("*ELEMENT, TYPE=C3D4, ELSET=PART{}\n", m);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
      const auto& nodes = mesh.tetrahedra[t];
      if (!material_of.empty() && material_of[t] != m) continue;
      out << fmt::format("{}, {}, {}, {}, {}\n", t + 1, nodes[0] + 1, nodes[1] + 1, nodes[2] + 1,
                         nodes[3] + 1);
    }
    out << fmt::format("*MATERIAL, NAME=M{}\n*ELASTIC\n{:.17g}, {:.17g}\n*DENSITY\n{:.10g}\n", m,
                       1e-6 * material.youngs_modulus, material.poisson_ratio, 1e-12 * material.density);
    out << fmt::format("*SOLID SECTION, ELSET=PART{}, MATERIAL=M{}\n", m, m);
  }
  out << "*BOUNDARY\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (mesh.nodes[n][2] == 0) out << fmt::format("{}, 1, 3\n", n + 1);
  }
  out << step << (step.find("GROWING") == std::string::npos ? "*CLOAD\n" : "*CLOAD, AMPLITUDE=GROWING\n");
  for (std::size_t i = 0; i < nodal_force.size(); ++i) {
    if (nodal_force[i] != 0) out << fmt::format("{}, {}, {:.17g}\n", i / 3 + 1, i % 3 + 1, nodal_force[i]);
  }
  out << output << "*END STEP\n";
}

/// Displacements from the .dat file: lines "node ux uy uz".
std::vector<double> read_displacements(const std::filesystem::path& file, std::size_t n_nodes) {
  std::vector<double> u(3 * n_nodes, NAN);
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::size_t node = 0;
    double x = 0, y = 0, z = 0;
    if (fields >> node >> x >> y >> z && node >= 1 && node <= n_nodes) {
      u[3 * node - 3] = 1e-3 * x;
      u[3 * node - 2] = 1e-3 * y;
      u[3 * node - 1] = 1e-3 * z;
    }
  }
  return u;
}

bool run_calculix(const std::filesystem::path& folder) {
  const std::string command = "cd '" + folder.string() + "' && OMP_NUM_THREADS=1 ccx plate > ccx.log 2>&1";
  return std::system(command.c_str()) == 0;
}

void compare_static(const input::Parameters& parameters, bool is_mixed) {
  const geometry::Body plate = *geometry::make_body(parameters.specimen);
  const auto base = geometry::make_mother_points(plate, parameters.mesh, 1);
  const auto mesh = geometry::make_realization(plate, base, parameters.mesh, 1, 0);
  auto subdomain = test::whole(mesh);
  if (is_mixed)
    for (std::size_t t = 0; t < subdomain.tetrahedra.size(); ++t)
      subdomain.material.push_back(t * t % 3 == 0 ? 0 : 1);
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain,
                               fracture::make_material_field(parameters, 0, fracture::span_of(subdomain)));
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  auto law = test::tuler_butcher(parameters.fracture, subdomain);
  const QuasiStaticLoading loading(self, body, loads, law, 1e-5);
  std::vector<double> force(3 * mesh.nodes.size(), 0.0);
  loads.add_forces(0, force);

  const test::TemporaryFolder folder;
  write_input(folder.path() / "plate.inp", parameters, mesh, subdomain.material, force, "*STEP\n*STATIC\n",
              "*NODE PRINT, NSET=ALL\nU\n");
  ASSERT_TRUE(run_calculix(folder.path())) << "CalculiX (Debian's calculix-ccx) is needed for this test";
  const auto reference = read_displacements(folder.path() / "plate.dat", mesh.nodes.size());

  double worst = 0, largest = 0;
  const auto u = loading.displacement().local();
  for (std::size_t i = 0; i < u.size(); ++i) {
    ASSERT_FALSE(std::isnan(reference[i])) << "CalculiX printed no displacement for node " << i / 3;
    worst = std::max(worst, std::abs(u[i] - reference[i]));
    largest = std::max(largest, std::abs(reference[i]));
  }
  std::printf(
      "%zu nodes, %zu tetrahedra: largest difference to CalculiX %.2e of the largest displacement %.4g mm\n",
      mesh.nodes.size(), mesh.tetrahedra.size(), worst / largest, 1e3 * largest);
  EXPECT_LT(worst, 1e-6 * largest);
}

TEST(CalculiX, GivesTheSameStaticDisplacements) {
  compare_static(notched_plate(), false);
}

TEST(CalculiX, GivesTheSameStaticDisplacementsOfTwoMaterials) {
  auto parameters = notched_plate();
  parameters.materials[0].name = "epoxy";
  parameters.materials.push_back({70e9, 0.2, 2500, "glass"});
  compare_static(parameters, true);
}

/// Blocks "displacements ... time t", each with lines "node ux uy uz": z displacement of the highest node.
std::vector<std::pair<double, double>> read_history(const std::filesystem::path& file) {
  std::vector<std::pair<double, double>> history;
  std::ifstream in(file);
  std::string line;
  double time = 0;
  while (std::getline(in, line)) {
    if (const auto at = line.find("time"); at != std::string::npos) {
      time = std::stod(line.substr(at + 4));
      continue;
    }
    std::istringstream fields(line);
    std::size_t node = 0;
    double x = 0, y = 0, z = 0;
    if (fields >> node >> x >> y >> z) history.emplace_back(time, 1e-3 * z);
  }
  return history;
}

TEST(CalculiX, GivesTheSameDisplacementHistory) {
  // A load that grows for 30 us and then stays constant; CalculiX integrates implicitly, with a consistent
  // mass matrix.
  auto parameters = notched_plate();
  parameters.boundaries.back() = test::boundary(Face::z_max, BoundaryKind::force, {}, {0, 0, 100});
  parameters.boundaries.back().history = {{0, 0}, {30e-6, 1}};
  parameters.mesh.notch_spacing = 0.001;
  const geometry::Body plate = *geometry::make_body(parameters.specimen);
  const auto base = geometry::make_mother_points(plate, parameters.mesh, 1);
  const auto mesh = geometry::make_realization(plate, base, parameters.mesh, 1, 0);
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, parameters.material());
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  std::vector<double> force(3 * mesh.nodes.size(), 0.0);
  loads.add_forces(30e-6, force);
  std::size_t watched = 0;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (mesh.nodes[n] == geometry::Point{0, 0, parameters.specimen.size[2]}) watched = n;

  const double duration = test::is_full() ? 60e-6 : 40e-6;
  constexpr double increment = 0.5e-6;
  const test::TemporaryFolder folder;
  write_input(folder.path() / "plate.inp", parameters, mesh, {}, force,
              fmt::format("*NSET, NSET=WATCHED\n{}\n*AMPLITUDE, NAME=GROWING\n0, 0, 30e-6, 1, 1, 1\n"
                          "*STEP, INC=100000\n*DYNAMIC, DIRECT, ALPHA=0\n{}, {}\n",
                          watched + 1, increment, duration),
              "*NODE PRINT, NSET=WATCHED\nU\n");
  ASSERT_TRUE(run_calculix(folder.path())) << "CalculiX (Debian's calculix-ccx) is needed for this test";
  const auto reference = read_history(folder.path() / "plate.dat");
  ASSERT_EQ(reference.size(), static_cast<std::size_t>(std::lround(duration / increment)));

  auto law = test::unbreakable(subdomain);
  const MotionContext context{&self, &body, &loads, &law};
  MotionState state{parallel::NodeField(self, subdomain.layout), parallel::NodeField(self, subdomain.layout)};
  const auto motion = make_fixed_point_motion(context, input::Precision::double_, 0, duration, state);
  const auto& map = splitting(input::Integrator::verlet);
  const double stable =
      map.stability_limit / largest_frequency(self, subdomain, body.operators(), body.force());
  const auto n_inner = static_cast<int>(std::ceil(increment / (0.5 * stable)));
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < reference.size(); ++i) {
    for (int k = 0; k < n_inner; ++k)
      motion->step(map.even, increment / n_inner, increment * (static_cast<double>(i) + double(k) / n_inner));
    motion->read(state);
    worst = std::max(worst, std::abs(state.displacement.local()[3 * watched + 2] - reference[i].second));
    largest = std::max(largest, std::abs(reference[i].second));
  }
  std::printf(
      "%zu nodes, growing load, %.0f us: corner's displacement within %.2e of its largest value %.4g mm by "
      "CalculiX (accepted: 1e-2)\n",
      mesh.nodes.size(), 1e6 * duration, worst / largest, 1e3 * largest);
  EXPECT_LT(worst, 1e-2 * largest);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
