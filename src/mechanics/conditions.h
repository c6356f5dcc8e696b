// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "input/model.h"
#include "mechanics/elasticity.h"
#include "mechanics/governing_condition.h"
#include "mechanics/load_curve.h"
#include "mechanics/node_stiffness.h"
#include "mechanics/operators.h"
#include "mechanics/tensor.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// A nodal force pattern and its amplitude: the force on node n in direction `component` is amplitude(t)
/// weight[i].
struct ForcePattern {
  int component = 0;
  LoadCurve amplitude;              ///< total force [N], traction [Pa], acceleration [m/s^2] and the like
  std::vector<std::int32_t> nodes;  ///< owned local nodes, ascending
  /// Share of the total (adds up to 1 over all ranks), area [m^2], mass [kg] and the like, times the factor;
  /// 0 where the load has ended.
  std::vector<double> weight;
  double total_weight = 0;     ///< sum of magnitudes over all ranks, before any of the load has ended
  double resultant = 0;        ///< likewise with signs: force on the body per amplitude
  int condition = 0;           ///< index into Conditions::conditions
  bool is_body_force = false;  ///< acts on the whole body, with all pieces that come loose
  /// Per node: true if its component is also prescribed by a motion. The force there acts on the support or
  /// drive, and does no work on the body. Empty: at no node.
  std::vector<std::uint8_t> is_driven = {};

  /// The still active parts of total_weight and resultant, if some of the load has ended.
  std::optional<double> left_weight = {}, left_resultant = {};

  bool does_work_at(std::size_t i) const { return is_driven.empty() || is_driven[i] == 0; }
  double acting_weight() const { return left_weight.value_or(total_weight); }
  double acting_resultant() const { return left_resultant.value_or(resultant); }
};

/// Displacement components that follow a curve, times a factor of each node. Each component of a node belongs
/// to one motion only: where conditions meet, to one that fixes it, otherwise to the first in the input.
struct PrescribedMotion {
  int component = 0;
  bool is_velocity = false;  ///< the curve is a velocity, and the displacement its integral from time 0
  bool is_fixed = false;
  LoadCurve curve;
  std::vector<std::int32_t> nodes;  ///< owned local nodes, ascending
  bool has_factor = false;          ///< on any rank
  std::vector<double> factor = {};  ///< per node; empty: 1 at all of them
  int condition = 0;                ///< index into the input's boundaries

  double factor_at(std::size_t i) const { return factor.empty() ? 1 : factor[i]; }
  bool never_moves() const { return is_fixed || curve.is_zero(); }
  /// At factor 1, as are the velocities.
  double displacement(double time) const { return is_velocity ? curve.integral(time) : curve.at(time); }
  double velocity(double time) const { return is_velocity ? curve.at(time) : curve.slope(time); }
  /// Like the slope of a curve over a step.
  double velocity(double time, const StepSpan& step) const;
};

/// A wave-absorbing face (Lysmer and Kuhlemeyer 1969): dashpots with, per area, density times wave speed,
/// dilatational along the normal and shear across it. Waves at normal incidence leave the body.
struct Absorber {
  std::vector<std::int32_t> nodes;  ///< owned local nodes, ascending
  /// Damping force per velocity; zero in components prescribed by a condition [kg/s].
  std::vector<Symmetric> impedance;
  int condition = 0;  ///< index into the input's boundaries
};

/// The nodes of a condition, over which its mean displacement is taken.
struct ConditionNodes {
  std::vector<std::int32_t> nodes;  ///< owned local nodes, ascending
  std::vector<double>
      share;  ///< of the loaded area, or of the constrained nodes; adds up to 1 over all ranks
  std::vector<std::uint8_t> has_ended = {};  ///< per node: its load has ended; empty: at no node
  double acting_share = 1;                   ///< of the nodes whose load has not ended, over all ranks

  bool acts_at(std::size_t i) const { return has_ended.empty() || has_ended[i] == 0; }
};

/// Owned local nodes, ascending, for each condition of the input.
using NodesOfConditions = std::vector<std::vector<std::int32_t>>;

/// The input's boundary conditions on one subdomain. A condition applies to whole boundary triangles, whose
/// linear shape functions distribute its loads; to whole mesh edges if its region is a line, or to a node if
/// it is a point. In every realization their area and centroid are those of geometry::ConditionRegion.
struct Conditions {
  std::vector<ForcePattern> forces;
  std::vector<PrescribedMotion> motions;
  std::vector<Absorber> absorbers = {};
  /// In the order of the input: first its boundaries, then its body forces.
  std::vector<ConditionNodes> conditions = {};
  /// Local tetrahedra, ascending, that touch a node with a prescribed motion; needed for reactions.
  std::vector<std::int32_t> constrained_tetrahedra = {};
  std::vector<GoverningCondition> governing = {};
  std::vector<Support> supports = {};  ///< by anything else that holds the body
  bool has_supports = false;           ///< on any rank

  /// Permanently ends the loads of conditions at some of their nodes. Collective.
  void end_loads(const parallel::Communicator& group, const NodesOfConditions& nodes);
  /// Adds the nodal forces at `time` to `force` (3 n_owned).
  void add_forces(double time, std::span<double> force) const;
  /// Writes the prescribed displacements at `time` into the owned part of `displacement`.
  void set_displacements(double time, std::span<double> displacement) const;
};

/// Collective (total areas are summed over the group).
/// @param material of each tetrahedron, which absorbing faces match
/// @throws parallel::AgreedError when a condition applies to no node or no area of the body
Conditions make_boundary_loads(const parallel::Communicator& group, const input::Model& model,
                               const geometry::Subdomain& subdomain, const MaterialField& material);
/// With the materials of the input as they are, without rasters and variations.
Conditions make_boundary_loads(const parallel::Communicator& group, const input::Model& model,
                               const geometry::Subdomain& subdomain);

/// Adds body forces (input::Model::body_forces), lumped like the masses: a force per mass at a node acts on
/// its mass. Collective.
void add_body_forces(const parallel::Communicator& group, std::span<const input::BodyLoad> forces,
                     const geometry::Subdomain& subdomain, const PdsOperators& operators, Conditions& loads);

}  // namespace crackle::mechanics
