// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "geometry/subdomain.h"
#include "mechanics/elasticity.h"
#include "mechanics/tensor.h"

#include <array>
#include <cstddef>
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

/// b^a of a tetrahedron and its volume from the corner coordinates.
inline TetrahedronOperator tetrahedron_operator(const geometry::Tetrahedron& nodes,
                                                const std::array<geometry::Point, 4>& x) {
  const Vector d1 = x[1] - x[0];
  const Vector d2 = x[2] - x[0];
  const Vector d3 = x[3] - x[0];
  const Vector n1 = cross(d2, d3);
  const Vector n2 = cross(d3, d1);
  const Vector n3 = cross(d1, d2);
  const double six_volumes = dot(d1, n1);
  TetrahedronOperator t{nodes, {}, six_volumes / 6};
  t.gradient[1] = n1 / six_volumes;
  t.gradient[2] = n2 / six_volumes;
  t.gradient[3] = n3 / six_volumes;
  t.gradient[0] = -1 * (t.gradient[1] + t.gradient[2] + t.gradient[3]);
  return t;
}

/// The operators of all tetrahedra of a subdomain, in its order. Each is computed when it is asked for: that
/// takes about as long as reading its 120 bytes, which would be a fifth of the memory of a large body.
class TetrahedronOperators {
public:
  /// @param subdomain its tetrahedra and nodes must outlive the object
  explicit TetrahedronOperators(const geometry::Subdomain& subdomain)
      : TetrahedronOperators(subdomain.tetrahedra, subdomain.nodes) {}
  TetrahedronOperators(std::span<const geometry::Tetrahedron> tetrahedra,
                       std::span<const geometry::Point> places)
      : tetrahedra_(tetrahedra), places_(places) {}

  TetrahedronOperator operator[](std::size_t tetrahedron) const {
    const geometry::Tetrahedron& nodes = tetrahedra_[tetrahedron];
    return tetrahedron_operator(nodes, {places_[index(nodes[0])], places_[index(nodes[1])],
                                        places_[index(nodes[2])], places_[index(nodes[3])]});
  }
  std::size_t size() const { return tetrahedra_.size(); }

  class Iterator {
  public:
    Iterator(const TetrahedronOperators& all, std::size_t at) : all_(&all), at_(at) {}
    TetrahedronOperator operator*() const { return (*all_)[at_]; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    bool operator==(const Iterator&) const = default;

  private:
    const TetrahedronOperators* all_;
    std::size_t at_;
  };
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size()}; }

private:
  std::span<const geometry::Tetrahedron> tetrahedra_;
  std::span<const geometry::Point> places_;
};

/// The same, of which the latest are kept: for loops that come back to the tetrahedra of a neighbourhood.
class RecentOperators {
public:
  explicit RecentOperators(const TetrahedronOperators& all) : all_(all), kept_(n_kept) {}

  /// Valid until the next call.
  const TetrahedronOperator& operator[](std::int32_t tetrahedron) {
    Kept& kept = kept_[index(tetrahedron) % n_kept];
    if (kept.number != tetrahedron) kept = {tetrahedron, all_[index(tetrahedron)]};
    return kept.value;
  }

private:
  static constexpr std::size_t n_kept = 1024;
  struct Kept {
    std::int32_t number = -1;
    TetrahedronOperator value{};
  };
  TetrahedronOperators all_;
  std::vector<Kept> kept_;
};

/// Time-independent operators on a subdomain: paper section 2, on the barycentric dual.
struct PdsOperators {
  TetrahedronOperators tetrahedra;
  /// M^a = rho sum V/4 of the owned nodes, and what dynamics::scale_masses adds [kg].
  std::vector<double> node_mass;
  std::vector<double> node_volume = {};  ///< sum V/4 of the owned nodes [m^3]
};

/// @param subdomain must outlive the operators
/// @param density of each local tetrahedron [kg/m^3]
PdsOperators make_operators(const geometry::Subdomain& subdomain, const TetrahedronField<double>& density);

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
