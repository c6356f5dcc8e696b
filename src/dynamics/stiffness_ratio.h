// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/term.h"
#include "fracture/breakable_body.h"
#include "mechanics/static_solver.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"

#include <cstddef>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// A body carries no load once its stiffness is below this share of the intact one: equilibria are only
/// accurate to this share of their loads, so anything below is rounding. A bar that hangs by one tetrahedron,
/// or a beam of ten times its original length, is still a thousand times stiffer.
inline constexpr double least_share = mechanics::rounding_allowance;

/// The stiffness of a bar equivalent to the whole body, along its longest extent [N/m]. Collective.
double bar_stiffness(const parallel::Communicator& group, const fracture::BreakableBody& body);

/// The stiffness against the current loads, relative to the intact body.
///
/// Forces and prescribed motions are treated separately, since they do no work on each other's displacements:
/// forces f by the compliance f . u, motions by the stiffness u . K u of the displacement that they cause.
/// Both give bounds for any admissible u, in equilibrium or not: the compliance is at least (f . u)^2 / (u .
/// K u), and the stiffness at most u . K u. Hence a share found negligible is truly negligible.
class StiffnessRatio {
public:
  /// References must outlive the object. Collective.
  /// @param loads forces first, then motions, then others, which do not count
  /// @param springs that hold nodes besides the body's stiffness
  /// @param unit displacement in the intact body for each force and each motion
  StiffnessRatio(const parallel::Communicator& group, const fracture::BreakableBody& body,
                 std::span<const UnitLoad> loads, std::span<const mechanics::NodeStiffness> springs,
                 std::span<const parallel::NodeField> unit);

  /// Upper bound of the smaller of the two shares; 1 if nothing strained the intact body. Bitwise equal for
  /// any number of ranks. Collective.
  /// @param time of the combined loads; if they are zero, their rates are used
  /// @param unit as before, in the current body
  double at(double time, std::span<const parallel::NodeField> unit) const;

private:
  using Matrix = std::vector<std::vector<double>>;
  double work(std::size_t force, std::span<const double> displacement) const;
  /// The intact body's value for these factors.
  static double intact(const Matrix& of_pairs, const std::vector<double>& factors);
  double share_of_forces(const std::vector<double>& factors, std::span<const parallel::NodeField> unit) const;
  double share_of_motions(const std::vector<double>& factors,
                          std::span<const parallel::NodeField> unit) const;

  const parallel::Communicator* group_;
  const fracture::BreakableBody* body_;
  std::span<const UnitLoad> forces_, motions_;
  std::vector<mechanics::NodeStiffness> springs_;
  Matrix compliance_;         // work of each force on the displacement due to each force [m/N, or per area]
  Matrix stiffness_;          // work of each motion's reactions on the displacement due to each motion [N/m]
  double bar_stiffness_ = 0;  // of a bar equivalent to the whole body [N/m]
};

}  // namespace crackle::dynamics
