// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/breakable_body.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Tells cheaply when breaks cannot have parted the body: nearly always all that a broken tetrahedron
/// connected is still connected close by, for example round the front of the crack.
class PartingWatch {
public:
  /// Collective. The body must outlive the object.
  PartingWatch(const parallel::Communicator& group, const fracture::BreakableBody& body,
               const mechanics::Conditions& loads);

  /// Notes local tetrahedra whose stiffness has changed. Local.
  void note(std::span<const std::int32_t> changed);

  /// The next answer is true: more may have changed than was noted, such as the conditions. Local.
  void forget() { is_known_ = false; }

  /// False if it is certain, as far as this rank counts the tetrahedra noted since the last call, that these
  /// have parted the body neither by faces nor by edges, unless into pieces on which no condition acts, each
  /// of less than separated_share of this rank's volume. True at the first call. Local.
  bool may_have_parted();

private:
  bool may_have_parted(std::int32_t tetrahedron);
  void find_patch(std::int32_t tetrahedron);
  bool are_faces_connected() const;
  bool are_nodes_connected() const;
  bool is_loaded(std::int32_t tetrahedron) const;
  bool owns_any(std::int32_t tetrahedron, std::size_t corner) const;
  bool may_come_off(std::int32_t node) const;

  const fracture::BreakableBody* body_;
  std::vector<std::uint8_t> is_loaded_;  // each local node
  /// Released edges of each local tetrahedron: between two answers those of the last one; during an answer
  /// the changes are made one after the other, so that each is judged by what the ones before have left.
  std::vector<mechanics::EdgeSet> released_;
  std::vector<std::int32_t> changed_;
  double small_;                     // volume below which a piece does not count [m^3]
  bool is_known_ = false;            // released_
  std::vector<std::int32_t> patch_;  // tetrahedra close to one, which comes first
  std::vector<std::int32_t> nodes_;  // their nodes, its own first
  // Place of each local tetrahedron and node among them; -1: none.
  std::vector<std::int32_t> place_, node_place_;
};

}  // namespace crackle::dynamics
