// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "input/model.h"
#include "mechanics/internal_force.h"
#include "mechanics/node_stiffness.h"
#include "mechanics/operators.h"
#include "parallel/communicator.h"

#include <vector>

namespace crackle::dynamics {

/// The share of the body's surface of each owned node: a third of each boundary triangle around it, 0 inside
/// the body [m^2]. Local; bitwise equal for any number of ranks.
std::vector<double> surface_areas(const geometry::Subdomain& subdomain);

/// The scale of contact between the surfaces of a body.
struct ContactScale {
  double friction = 0;  ///< Coulomb's coefficient
  /// The squared largest frequency at which contact makes a node alone oscillate, a share of that of the
  /// body: the stable step is shortened by 1 / sqrt(1 + share) [1/s^2]; 0: only cuts that close are in
  /// contact.
  double rate = 0;
  double spacing = 0;  ///< of nodes, on average [m]
};

/// Collective; bitwise equal for any number of ranks.
ContactScale contact_scale(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const mechanics::PdsOperators& operators, const mechanics::InternalForce& force,
                           const input::SurfaceContact& contact);

/// The stiffness of contact with rigid tools at each owned node, in proportion to the surface that it stands
/// for, up to a limit: on the body's own surface `tool_factor` times ContactScale::rate times the mass,
/// inside the body, where breaking may lay the node open, that without the factor [N/m]. Collective; bitwise
/// equal for any number of ranks.
std::vector<double> tool_stiffness(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                   const mechanics::PdsOperators& operators, const ContactScale& scale);
/// The body's own surface is there when the stable step is found.
inline constexpr double tool_factor = 2;

/// Springs at owned nodes to which the stable step is fitted: as stiff as contact between surfaces, or with
/// tools, is at most. Collective.
std::vector<mechanics::NodeStiffness> largest_contact(const parallel::Communicator& group,
                                                      const input::Model& model,
                                                      const geometry::Subdomain& subdomain,
                                                      const mechanics::PdsOperators& operators,
                                                      const ContactScale& scale);

}  // namespace crackle::dynamics
