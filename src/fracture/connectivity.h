// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "fracture/breakable_body.h"
#include "parallel/communicator.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::fracture {

/// For every local node the smallest node number in its piece, where pieces are connected by edges that still
/// carry load. Two nodes are in the same piece exactly if their labels are equal. Collective; equal for any
/// number of ranks.
std::vector<std::int64_t> piece_labels(const parallel::Communicator& group, const BreakableBody& body);

/// True if all edges of the face opposite to a corner carry load. Local.
bool carries_face(mechanics::EdgeSet released, std::size_t corner);

/// True if a tetrahedron is connected with its neighbour across the face opposite a corner: all edges of the
/// face carry load in both. Local.
/// @param released gives the edges of a tetrahedron that carry none
template <class ReleasedEdges>
bool is_connected_across(const BreakableBody& body, std::int32_t tetrahedron, std::size_t corner,
                         const ReleasedEdges& released) {
  const auto& neighbours = body.face_neighbours();
  const std::int32_t other = neighbours[index(tetrahedron)][corner];
  if (other < 0 || !carries_face(released(tetrahedron), corner)) return false;
  const auto& back = neighbours[index(other)];
  const mechanics::EdgeSet of_other = released(other);
  return of_other == mechanics::no_edge ||
         carries_face(of_other, index(std::ranges::find(back, tetrahedron) - back.begin()));
}

/// For every local tetrahedron the smallest tetrahedron number in its piece, where pieces are connected by
/// faces that is_connected_across() names; -1 for one that carries no load. Parts connected by
/// a node or an edge only are separate pieces. Valid for tetrahedra that touch a node of this rank.
/// Collective; equal for any number of ranks.
std::vector<std::int64_t> face_piece_labels(const parallel::Communicator& group, const BreakableBody& body);

}  // namespace crackle::fracture
