// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/breakable_body.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <vector>

namespace crackle::fracture {

/// For every local node the smallest node number of the piece that edges which still carry join it to. Two
/// nodes are in one piece exactly when their labels are equal. Collective; equal for any number of ranks.
std::vector<std::int64_t> piece_labels(const parallel::Communicator& group, const BreakableBody& body);

/// For every local tetrahedron the smallest tetrahedron number of the piece that faces join it to, each with
/// all its edges carrying in both tetrahedra; -1 for one that carries nothing. What hangs by a node or an
/// edge is another piece. Right for tetrahedra that touch a node of this rank. Collective; equal for any
/// number of ranks.
std::vector<std::int64_t> face_piece_labels(const parallel::Communicator& group, const BreakableBody& body);

}  // namespace crackle::fracture
