// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/breakable_body.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// A loose piece of at least this share of the volume means that the body has separated; smaller ones are
/// splinters.
inline constexpr double separated_share = 0.01;

// Body forces act on all pieces, so they do not count among the loads below.

/// True if two loads or motions act on no common face-connected piece: only hinges could transfer a load
/// between them; or if none acts on the largest piece, as below. With fewer than two of them, as
/// is_separated. Equal on every rank. Collective.
/// @param labels of the pieces, see fracture::piece_labels()
bool is_unloaded(const parallel::Communicator& group, const fracture::BreakableBody& body,
                 const mechanics::Conditions& loads, const std::vector<std::int64_t>& labels);

/// True if the body has separated: two loads or motions act on no common piece, or there is a second piece of
/// at least separated_share of the volume, or the largest piece has come off the prescribed motions, of which
/// there are some, and no load acts on it either. Equal on every rank. Collective.
/// @param labels of the pieces, see fracture::piece_labels()
bool is_separated(const parallel::Communicator& group, const fracture::BreakableBody& body,
                  const mechanics::Conditions& loads, const std::vector<std::int64_t>& labels);
bool is_separated(const parallel::Communicator& group, const fracture::BreakableBody& body,
                  const mechanics::Conditions& loads);

/// The local nodes of the loose pieces at some of these nodes: pieces without prescribed motion or support,
/// the largest one of the body only once the body has separated. Collective.
/// @param nodes local, of this rank @param labels of the pieces, see fracture::piece_labels()
std::vector<std::int32_t> nodes_of_loose_pieces_at(const parallel::Communicator& group,
                                                   const fracture::BreakableBody& body,
                                                   const mechanics::Conditions& loads,
                                                   const std::vector<std::int64_t>& labels,
                                                   const std::vector<std::int32_t>& nodes);

/// True if every load still acts on a piece with a prescribed motion, and body forces on no other, so that an
/// equilibrium exists; without
/// any prescribed motion, true if the body is in one piece. Pieces are connected by edges that still carry
/// load, so a hinge is enough. Equal on every rank. Collective.
/// @param labels of the pieces, see fracture::piece_labels()
bool loads_are_supported(const parallel::Communicator& group, const fracture::BreakableBody& body,
                         const mechanics::Conditions& loads, const std::vector<std::int64_t>& labels);

/// The same for pieces connected by faces all of whose edges still carry load.
bool loads_are_supported_by_faces(const parallel::Communicator& group, const fracture::BreakableBody& body,
                                  const mechanics::Conditions& loads);

}  // namespace crackle::dynamics
