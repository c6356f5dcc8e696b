// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/quasi_static.h"
#include "mechanics/conditions.h"
#include "mechanics/operators.h"

#include "support/box_mesh.h"
#include "support/job.h"
#include "support/plate_family.h"

#include <memory>
#include <string>
#include <vector>

namespace crackle::test {

/// Held at the bottom and pulled by 1 MPa at the top.
inline constexpr const char* pulled_plate = R"([[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
traction = ["0 MPa", "0 MPa", "1 MPa"]
)";

/// A plate with its mesh and its boundary conditions.
struct LoadedPlate {
  input::Parameters parameters;
  std::unique_ptr<const geometry::Body> body;
  geometry::Subdomain subdomain;
  parallel::Communicator self{MPI_COMM_SELF};

  explicit LoadedPlate(const PlateText& text) : parameters(input::parse(text.text(), "plate.toml")) {
    parameters.seed = 1;
    body = geometry::make_body(parameters);
    subdomain = whole(realization(parameters));
  }

  mechanics::PdsOperators operators() const {
    return mechanics::make_operators(subdomain, parameters.materials[0].density);
  }

  /// Equilibrium under the loads at t = 0, three components per node [m].
  std::vector<double> displacement() {
    fracture::BreakableBody breakable(subdomain, parameters.material());
    const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
    auto law = tuler_butcher(parameters.fracture, subdomain);
    const dynamics::QuasiStaticLoading loading(self, breakable, loads, law, 1e-5);
    const auto u = loading.displacement().local();
    return {u.begin(), u.end()};
  }
};

}  // namespace crackle::test
