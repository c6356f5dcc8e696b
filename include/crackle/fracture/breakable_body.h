// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/break_record.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/edges.h"
#include "crackle/mechanics/internal_force.h"
#include "crackle/mechanics/operators.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace crackle::fracture {

/// The seven cuts' vector areas of a tetrahedron: V b^a, then V (b^0 + b^k) for k = 1, 2, 3 [m^2].
std::array<mechanics::Vector, n_cuts> cut_areas(const mechanics::TetrahedronOperator& tetrahedron);

/// The cut with the largest normal traction n . sigma . n; ties go to the lower number.
int most_loaded_cut(const mechanics::TetrahedronOperator& tetrahedron, const mechanics::Symmetric& sigma);

/// A body that can break: its constant operators, its internal force and its broken set, on one subdomain.
///
/// Ranks that hold the same tetrahedron see the same stress bits, so they break it together without a
/// message.
class BreakableBody {
public:
  /// @param subdomain must outlive the object
  BreakableBody(const geometry::Subdomain& subdomain, const input::Material& material);
  BreakableBody(const BreakableBody&) = delete;
  BreakableBody& operator=(const BreakableBody&) = delete;

  const geometry::Subdomain& subdomain() const { return *subdomain_; }
  const mechanics::PdsOperators& operators() const { return operators_; }
  const mechanics::IsotropicElasticity& elasticity() const { return elasticity_; }
  const mechanics::Edges& edges() const { return edges_; }
  const mechanics::InternalForce& force() const { return *force_; }

  bool is_broken(std::int32_t tetrahedron) const {
    return broken_[static_cast<std::size_t>(tetrahedron)] != 0;
  }
  /// 1 for each local tetrahedron that is broken.
  std::span<const std::uint8_t> broken() const { return broken_; }
  /// Local tetrahedra in order of breaking.
  std::span<const std::int32_t> broken_tetrahedra() const { return order_; }
  /// Records of the breaks that this rank counts, in order of breaking.
  std::span<const Break> breaks() const { return records_; }

  mechanics::Symmetric strain(std::int32_t tetrahedron, std::span<const double> displacement) const {
    return mechanics::strain(operators_.tetrahedra[static_cast<std::size_t>(tetrahedron)], displacement);
  }
  mechanics::Symmetric stress(std::int32_t tetrahedron, std::span<const double> displacement) const {
    return elasticity_(strain(tetrahedron, displacement));
  }

  /// Opens all six dual facets; the record's energy and cut follow from the strain it had.
  void release(std::int32_t tetrahedron, const mechanics::Symmetric& strain, double load_time,
               double phase_time);

  /// Opens a tetrahedron that broke earlier, as its record tells.
  void restore(std::int32_t tetrahedron, const Break& record);

  /// Strain energies of the unbroken tetrahedra that this rank counts [J], one for each.
  std::vector<double> strain_energies(std::span<const double> displacement) const;
  /// Energies taken out by the breaks that this rank counts [J].
  std::vector<double> released_energies() const;

private:
  const geometry::Subdomain* subdomain_;
  mechanics::PdsOperators operators_;
  mechanics::Edges edges_;
  mechanics::IsotropicElasticity elasticity_;
  std::unique_ptr<mechanics::InternalForce> force_;
  std::vector<std::uint8_t> broken_;
  std::vector<std::int32_t> order_;
  std::vector<Break> records_;
};

}  // namespace crackle::fracture
