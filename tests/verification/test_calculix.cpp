// SPDX-License-Identifier: GPL-3.0-or-later
// The static solution on the same mesh by another program: CalculiX with its linear tetrahedron C3D4, to
// which the stiffness of PDS-FEM is identical.
#include "crackle/dynamics/quasi_static.h"
#include "crackle/geometry/mother_points.h"
#include "support/box_mesh.h"
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
namespace {

using input::BoundaryKind;
using input::Face;

input::Parameters notched_plate() {
  input::Parameters parameters;
  parameters.specimen.size = {0.003, 0.012, 0.03};
  parameters.specimen.notches = {{Face::y_min, 0.013, 0.003, 0.001}, {Face::y_max, 0.017, 0.003, 0.001}};
  parameters.mesh.spacing = 0.0015;
  parameters.mesh.notch_spacing = 0.0005;
  parameters.mesh.growth = 0.1;
  parameters.mesh.perturbation = 0.2;
  parameters.mesh.min_quality = 0.2;
  parameters.material = test::epoxy();
  parameters.fracture = {.strength = 35e6, .exponent = 2, .impulse = 1e4};
  parameters.boundaries.push_back(test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::force, {}, {20, -30, 100}));
  return parameters;
}

/// Writes the problem in CalculiX's input format. Millimetres, newtons, megapascals: its output has few
/// digits, which small numbers in metres would not change but which people read more easily so.
void write_input(const std::filesystem::path& file, const input::Parameters& parameters,
                 const geometry::Realization& mesh, const std::vector<double>& nodal_force) {
  std::ofstream out(file);
  out << "*NODE, NSET=ALL\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const auto& p = mesh.nodes[n];
    out << fmt::format("{}, {:.17g}, {:.17g}, {:.17g}\n", n + 1, 1e3 * p[0], 1e3 * p[1], 1e3 * p[2]);
  }
  out << "*ELEMENT, TYPE=C3D4, ELSET=BODY\n";
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const auto& nodes = mesh.tetrahedra[t];
    out << fmt::format("{}, {}, {}, {}, {}\n", t + 1, nodes[0] + 1, nodes[1] + 1, nodes[2] + 1, nodes[3] + 1);
  }
  out << fmt::format("*MATERIAL, NAME=EPOXY\n*ELASTIC\n{:.17g}, {:.17g}\n",
                     1e-6 * parameters.material.youngs_modulus, parameters.material.poisson_ratio);
  out << "*SOLID SECTION, ELSET=BODY, MATERIAL=EPOXY\n*BOUNDARY\n";
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (mesh.nodes[n][2] == 0) out << fmt::format("{}, 1, 3\n", n + 1);
  }
  out << "*STEP\n*STATIC\n*CLOAD\n";
  for (std::size_t i = 0; i < nodal_force.size(); ++i) {
    if (nodal_force[i] != 0) out << fmt::format("{}, {}, {:.17g}\n", i / 3 + 1, i % 3 + 1, nodal_force[i]);
  }
  out << "*NODE PRINT, NSET=ALL\nU\n*END STEP\n";
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

TEST(CalculiX, GivesTheSameStaticDisplacements) {
  const auto parameters = notched_plate();
  const geometry::Body plate(parameters.specimen);
  const auto base = geometry::make_mother_points(plate, parameters.mesh, 1);
  const auto mesh = geometry::make_realization(plate, base, parameters.mesh, 1, 0);
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, parameters.material);
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  fracture::TulerButcher criterion(parameters.fracture, subdomain.tetrahedra.size());
  const QuasiStaticLoading loading(self, body, loads, criterion, 1e-5);
  std::vector<double> force(3 * mesh.nodes.size(), 0.0);
  loads.add_forces(0, force);

  const test::TemporaryFolder folder;
  write_input(folder.path() / "plate.inp", parameters, mesh, force);
  const std::string command =
      "cd '" + folder.path().string() + "' && OMP_NUM_THREADS=1 ccx plate > ccx.log 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << "CalculiX (Debian's calculix-ccx) is needed for this test";
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

}  // namespace
}  // namespace crackle::dynamics
