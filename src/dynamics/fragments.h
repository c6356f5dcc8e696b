// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/sample_result.h"
#include "fracture/breakable_body.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <span>

namespace crackle::dynamics {

// Masses, momenta and energies are exact sums over the nodes: the same for any number of ranks.

/// The pieces of the body, on the root; empty elsewhere. Collective.
/// @param labels of local nodes, see fracture::piece_labels()
/// @param frozen 1 for each owned node that is; empty: none
/// @param displacement 3 n_owned or more [m]
/// @param velocity 3 n_owned or more; empty: at rest [m/s]
Fragments find_fragments(const parallel::Communicator& group, const fracture::BreakableBody& body,
                         std::span<const std::int64_t> labels, std::span<const std::uint8_t> frozen,
                         std::span<const double> displacement, std::span<const double> velocity);

/// The same in numbers, without frozen_energy. Collective.
/// @param time of the count [s]
FragmentCount count_fragments(const parallel::Communicator& group, const fracture::BreakableBody& body,
                              std::span<const std::int64_t> labels, std::span<const std::uint8_t> frozen,
                              double time);

}  // namespace crackle::dynamics
