// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/elasticity.h"
#include "crackle/mechanics/tensor.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// The PDS operators of one tetrahedron on the barycentric dual.
struct TetrahedronOperator {
  geometry::Tetrahedron nodes;     ///< local numbers
  std::array<Vector, 4> gradient;  ///< b^a = (1/V) integral of grad phi^a = grad N_a [1/m]
  double volume;                   ///< V [m^3]
};

/// Time-independent operators on a subdomain: paper section 2, on the barycentric dual.
struct PdsOperators {
  std::vector<TetrahedronOperator> tetrahedra;  ///< in the subdomain's order
  std::vector<double> node_mass;                ///< M^a = rho sum V/4 of the owned nodes [kg]
  std::vector<double> node_volume = {};         ///< sum V/4 of the owned nodes [m^3]
};

/// @param density of each local tetrahedron [kg/m^3]
PdsOperators make_operators(const geometry::Subdomain& subdomain, const TetrahedronField<double>& density);

/// b^a of a tetrahedron and its volume from the corner coordinates.
TetrahedronOperator tetrahedron_operator(const geometry::Tetrahedron& nodes,
                                         const std::array<geometry::Point, 4>& x);

/// An upper bound on the entries of every tetrahedron's stiffness matrix [N/m].
double stiffness_bound(const PdsOperators& operators, const ElasticityField& elasticity);

/// Strain sym sum_a u^a (x) b^a from local displacements (3 n_local).
inline Symmetric strain(const TetrahedronOperator& t, std::span<const double> displacement) {
  Symmetric e{};
  for (std::size_t a = 0; a < 4; ++a) {
    const double* u = &displacement[3 * index(t.nodes[a])];
    const Vector& b = t.gradient[a];
    e[0] += u[0] * b[0];
    e[1] += u[1] * b[1];
    e[2] += u[2] * b[2];
    e[3] += 0.5 * (u[1] * b[2] + u[2] * b[1]);
    e[4] += 0.5 * (u[0] * b[2] + u[2] * b[0]);
    e[5] += 0.5 * (u[0] * b[1] + u[1] * b[0]);
  }
  return e;
}

/// The local tetrahedra around each local node, ascending.
struct NodeTetrahedra {
  std::vector<std::int32_t> offset;  ///< n_local + 1
  std::vector<std::int32_t> tetrahedron;
  std::span<const std::int32_t> operator[](std::int32_t node) const {
    const auto n = static_cast<std::size_t>(node);
    return {tetrahedron.data() + offset[n], static_cast<std::size_t>(offset[n + 1] - offset[n])};
  }
};
NodeTetrahedra node_tetrahedra(const geometry::Subdomain& subdomain);

}  // namespace crackle::mechanics
