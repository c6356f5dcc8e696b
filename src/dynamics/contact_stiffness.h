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

/// Springs at all owned nodes to which the stable step is fitted: as stiff as contact is at most.
std::vector<mechanics::NodeStiffness> largest_contact(const ContactScale& scale,
                                                      const mechanics::PdsOperators& operators);

}  // namespace crackle::dynamics
