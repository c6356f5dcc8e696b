// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/breakable_body.h"
#include "crackle/mechanics/boundary_loads.h"
#include "crackle/mechanics/static_solver.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"

#include <cstddef>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// A body carries nothing once it offers less than this share of the stiffness that it had when it was
/// intact: equilibria are right to this share of their loads only, so what is below is rounding. A bar that
/// hangs by one tetrahedron, or a beam of ten times its first length, has a thousand times more.
inline constexpr double least_share = mechanics::rounding_allowance;

/// The stiffness against the present loads, over that of the intact body.
///
/// Forces and prescribed motions are treated separately, since they do no work on each other's displacements:
/// forces f by the compliance f . u, motions by the stiffness u . K u of the displacement that they cause.
/// Both are bounds for any admissible u, equilibrium or not: the compliance is at least
/// (f . u)^2 / (u . K u), and the stiffness at most u . K u. So a share found negligible is truly negligible.
class CarriedShare {
public:
  /// References must outlive the object. Collective.
  /// @param unit displacement in the intact body for each force pattern of the loads, then for each motion
  ///   that moves
  CarriedShare(const parallel::Communicator& group, const fracture::BreakableBody& body,
               const mechanics::BoundaryLoads& loads, std::span<const parallel::NodeField> unit);

  /// The smaller share of the two, from above; 1 where nothing strained the intact body. Equal bits for any
  /// number of ranks. Collective.
  /// @param time of the loads that are combined; where they are zero, their rates are
  /// @param unit as before, in the present body
  double at(double time, std::span<const parallel::NodeField> unit) const;

private:
  using Matrix = std::vector<std::vector<double>>;
  double work(std::size_t pattern, const std::vector<double>& displacement) const;
  /// The intact body's, for these factors.
  static double intact(const Matrix& of_pairs, const std::vector<double>& factors);
  double share_of_forces(const std::vector<double>& factors, std::span<const parallel::NodeField> unit) const;
  double share_of_motions(const std::vector<double>& factors,
                          std::span<const parallel::NodeField> unit) const;

  const parallel::Communicator* group_;
  const fracture::BreakableBody* body_;
  const mechanics::BoundaryLoads* loads_;
  Matrix compliance_;         // work of each force on the displacement of each [m/N, or per area]
  Matrix stiffness_;          // work of each motion's reactions on the displacement of each [N/m]
  double bar_stiffness_ = 0;  // of a bar made of the whole body [N/m]
};

}  // namespace crackle::dynamics
