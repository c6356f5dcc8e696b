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

/// Points of the body at which its state is recorded. Displacement and velocity are interpolated linearly in
/// the tetrahedron containing the point; so is the stress, from nodal values that are volume-weighted means
/// over the adjacent tetrahedra.
class Probes {
public:
  /// Locates the points in this realization; a point left outside by the faceted surface is moved to the
  /// nearest tetrahedron. Collective. The body must outlive the object.
  Probes(const parallel::Communicator& group, const fracture::BreakableBody& body,
         const std::vector<input::Probe>& probes);

  /// The values at all points, bitwise equal on every rank and for any partition. Collective.
  /// @param displacement with current ghosts
  /// @param velocity of a moving body, or nullptr
  std::vector<ProbeValue> read(const parallel::NodeField& displacement,
                               const parallel::NodeField* velocity) const;

private:
  /// This rank's contribution to the values at one point.
  struct Place {
    std::vector<std::pair<std::int32_t, double>> nodes;       ///< owned nodes with their weights
    std::vector<std::pair<std::int32_t, double>> tetrahedra;  ///< tetrahedra around these nodes, likewise
  };

  const parallel::Communicator* group_;
  const fracture::BreakableBody* body_;
  std::vector<Place> places_;
};

}  // namespace crackle::dynamics
