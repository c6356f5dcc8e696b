// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/breakable_body.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <vector>

namespace crackle::fracture {

/// For every local node the smallest node number in its piece, where pieces are connected by edges that still
/// carry load. Two nodes are in the same piece exactly if their labels are equal. Collective; equal for any
/// number of ranks.
std::vector<std::int64_t> piece_labels(const parallel::Communicator& group, const BreakableBody& body);

/// True if a tetrahedron is connected with its neighbour across the face opposite a corner: all edges of the
/// face carry load in both. Local.
bool is_connected_across(const BreakableBody& body, std::int32_t tetrahedron, std::size_t corner);

/// For every local tetrahedron the smallest tetrahedron number in its piece, where pieces are connected by
/// faces that is_connected_across() names; -1 for one that carries no load. Parts connected by
/// a node or an edge only are separate pieces. Valid for tetrahedra that touch a node of this rank.
/// Collective; equal for any number of ranks.
std::vector<std::int64_t> face_piece_labels(const parallel::Communicator& group, const BreakableBody& body);

}  // namespace crackle::fracture
