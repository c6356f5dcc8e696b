// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/sample_result.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/input/parameters.h"
#include "crackle/parallel/communicator.h"
#include "crackle/parallel/node_field.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// Places of the body at which its state is followed. Displacement and velocity are interpolated linearly in
/// the tetrahedron round the place; so is the stress, between nodes that have the mean of their tetrahedra by
/// volume.
class Probes {
public:
  /// Finds the places in this realization; one that a curve's chords leave outside is moved to the nearest
  /// tetrahedron. Collective. The body must outlive the object.
  Probes(const parallel::Communicator& group, const fracture::BreakableBody& body,
         const std::vector<input::Probe>& probes);

  /// The values at all places, equal bits on every rank for any partition. Collective.
  /// @param displacement with ghosts up to date
  /// @param velocity of a moving body, or nullptr
  std::vector<ProbeValue> read(const parallel::NodeField& displacement,
                               const parallel::NodeField* velocity) const;

private:
  /// What this rank adds to the values at one place.
  struct Place {
    std::vector<std::pair<std::int32_t, double>> nodes;       ///< owned, with their weights
    std::vector<std::pair<std::int32_t, double>> tetrahedra;  ///< round these nodes, likewise
  };

  const parallel::Communicator* group_;
  const fracture::BreakableBody* body_;
  std::vector<Place> places_;
};

}  // namespace crackle::dynamics
