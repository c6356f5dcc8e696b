// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/subdomain.h"
#include "input/model.h"
#include "mechanics/elasticity.h"
#include "mechanics/internal_force.h"
#include "mechanics/operators.h"
#include "parallel/communicator.h"

#include <optional>
#include <string>
#include <vector>

namespace crackle::dynamics {

/// Mass added for a longer stable step.
struct MassScaling {
  double share = 0;           ///< of the body's mass
  double corridor_share = 0;  ///< that added in the corridor, of its mass
  double node_share = 0;      ///< of the nodes, to which mass is added
  double gain = 1;            ///< factor of the stable step without springs

  bool operator==(const MassScaling&) const = default;
};

/// A bound on the body's largest squared frequency by the rows of each owned node in M^-1 K, of which the
/// largest holds (Gershgorin's, for blocks of 3 x 3, with those between nodes bounded by tetrahedra). It is
/// too high by a factor of some 2, at all nodes alike, so that it shows which are the few that decide. Local;
/// bitwise equal for any number of ranks. [1/s^2]
std::vector<double> frequency_bounds(const geometry::Subdomain& subdomain,
                                     const mechanics::PdsOperators& operators,
                                     const mechanics::ElasticityField& elasticity);

/// With input::Time::mass_scaling adds mass at the nodes of the highest bounds, such that these become equal,
/// and as low as they can with at most the given share of mass added to the body and to its corridor: where
/// the spacing is at most 1.5 times the finest, that which 1 % of the nodes are below. A node's spacing is
/// that of the mean volume of the tetrahedra around it. Collective; bitwise equal for any number of ranks.
/// @param operators take the new masses
/// @param force of the body with these operators
std::optional<MassScaling> scale_masses(const parallel::Communicator& group, const input::Model& model,
                                        const geometry::Subdomain& subdomain,
                                        mechanics::PdsOperators& operators,
                                        const mechanics::MaterialField& material,
                                        const mechanics::InternalForce& force);

/// "0.02 % of the mass, ...": for people.
std::string to_string(const MassScaling& scaling);

}  // namespace crackle::dynamics
