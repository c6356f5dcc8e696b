// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"
#include "fracture/breakable_body.h"
#include "parallel/communicator.h"

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// A node of the surface and a face of the surface that it may soon meet. Nodes by their numbers in the
/// realization.
struct ContactPair {
  std::int64_t node;
  std::int64_t face;  ///< 4 times the number of the face's tetrahedron, plus that of the corner opposite
  std::array<std::int64_t, 4>
      corners;        ///< of the face, seen counterclockwise from outside, and the one opposite
  std::int64_t open;  ///< bit k: the face opposite corner k belongs to the surface, too
  double depth;       ///< up to which the node counts as below the face [m]
  double gap = 0;     ///< between node and face at the search, at least [m]

  bool operator<(const ContactPair& other) const {
    return std::pair(node, face) < std::pair(other.node, other.face);
  }
};

/// A node finds a face up to this far beyond the face's edges, in barycentric coordinates, so that none falls
/// between two faces.
inline constexpr double found_beyond = 0.01;

/// How far a node and a face must move, at least, before they may touch [m].
/// @param normal unit vector out of the face
double contact_gap(const Vector& node, const std::array<Vector, 3>& face, const Vector& normal, double depth);

/// Twice the way of nodes that a search looks ahead [m].
struct ContactMargins {
  double of_most;
  double of_fast;
  std::span<const std::uint8_t> is_fast;  ///< 1 for each local node that is
};

/// The pairs that may meet before nodes have moved by half of their margins, of all ranks, on every rank,
/// ascending: those whose gap is less than the mean of the margins of node and face. The surface is that of
/// the unbroken tetrahedra. Left out are pairs that were neighbours in the surface before anything moved: the
/// node not in front of the face. Collective; agrees before its messages.
/// @param displacement of local nodes [m]
std::vector<ContactPair> find_contact_pairs(const parallel::Communicator& group,
                                            const fracture::BreakableBody& body,
                                            std::span<const Vector> displacement,
                                            const ContactMargins& margins);

}  // namespace crackle::dynamics
