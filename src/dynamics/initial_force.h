// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/breakable_body.h"
#include "crackle/mechanics/operators.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// The nodal forces of the initial strain of a body in motion, during which that is constant: by these the
/// internal force is less than stiffness times displacement. Bitwise independent of the partition: each is
/// the sum over the tetrahedra around the node, in ascending order.
class InitialForce {
public:
  /// @param body must outlive the object
  explicit InitialForce(const fracture::BreakableBody& body);

  bool is_none() const { return force_.empty(); }
  std::span<const double> values() const { return force_; }  ///< 3 n_owned, unless there is none [N]

  /// Follows the stiffness of these tetrahedra. @return the owned nodes whose force may have changed
  std::span<const std::int32_t> update(std::span<const std::int32_t> tetrahedra);

private:
  void sum_at(std::int32_t node);

  const fracture::BreakableBody* body_;
  mechanics::NodeTetrahedra around_;
  std::vector<double> force_;
  std::vector<std::int32_t> changed_;
};

}  // namespace crackle::dynamics
