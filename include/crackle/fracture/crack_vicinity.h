// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/fracture/breakable_body.h"
#include "crackle/fracture/criterion.h"
#include "crackle/fracture/stress_average.h"
#include "crackle/input/parameters.h"
#include "crackle/mechanics/operators.h"
#include "crackle/parallel/communicator.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

namespace crackle::fracture {

/// Nucleation and growth of cracks have different thresholds if the input gives both a strength and a
/// toughness: the strength holds where there is no crack, and the threshold that gives the toughness at the
/// local spacing holds at a crack, that is, for tetrahedra that share a node with a broken one or lie at the
/// square end of a slot. Where the toughness requires the higher threshold, that one holds everywhere.
///
/// In a dynamic phase a broken tetrahedron lowers the strength around it after the time in which a
/// dilatational wave, the fastest there is, crosses one spacing. Without this delay, tetrahedra whose stress
/// lies between the two thresholds would break one after another in each step, faster than any wave could
/// unload them.
///
/// Follows the cracks of a body and lowers the criterion's strengths accordingly.
class CrackVicinity {
public:
  /// Lowers the strengths at the ends of slots. Local.
  /// @param growth_strengths of each local tetrahedron at a crack [Pa]
  /// @param average relative to the criterion's strengths, or nullptr
  /// @param spacings of the mesh at each local tetrahedron [m]
  CrackVicinity(const BreakableBody& body, Criterion& criterion, StressAverage* average,
                std::vector<double> growth_strengths, const input::Specimen& specimen,
                std::span<const double> spacings);

  /// Lowers the strengths near broken tetrahedra that were not yet counted as a crack. Collective; does not
  /// agree() before. A rank that fails before its communication throws; the others then do nothing.
  /// @param phase_time since the start of the dynamic phase [s]; infinity: all that is broken is a crack
  /// @return the local tetrahedra whose strength has changed, ascending
  std::span<const std::int32_t> update(const parallel::Communicator& group, double phase_time = infinity);

private:
  /// A broken tetrahedron that does not act on its surroundings yet.
  struct Arriving {
    std::int32_t tetrahedron;
    double broke_at;  // phase time [s]
  };
  void lower(std::int32_t tetrahedron);

  const BreakableBody* body_;
  Criterion* criterion_;
  StressAverage* average_;
  std::vector<double> growth_strengths_;
  std::vector<double> delays_;  // of each local tetrahedron [s]
  mechanics::NodeTetrahedra round_node_;
  std::unordered_map<std::int64_t, std::int32_t> local_node_;  // by number in the realization
  std::vector<std::uint8_t> at_crack_;                         // of each local node
  std::size_t n_seen_ = 0;                                     // breaks counted by this rank
  std::vector<Arriving> arriving_;                             // of these
  std::vector<std::int32_t> changed_;
};

/// The vicinity for an intact body, or none if the input does not distinguish nucleation and growth.
/// Collective; equal for any number of ranks.
std::unique_ptr<CrackVicinity> make_crack_vicinity(const parallel::Communicator& group,
                                                   const input::Parameters& parameters, std::uint64_t sample,
                                                   const BreakableBody& body, Criterion& criterion,
                                                   StressAverage* average);

}  // namespace crackle::fracture
