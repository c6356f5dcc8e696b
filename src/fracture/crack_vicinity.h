// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "fracture/breakable_body.h"
#include "fracture/criterion.h"
#include "fracture/nodal_means.h"
#include "fracture/stress_average.h"
#include "geometry/mother_points.h"
#include "input/model.h"
#include "mechanics/operators.h"
#include "parallel/communicator.h"
#include "plane/shape.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crackle::fracture {

/// A square end of a slot.
struct SquareEnd {
  std::size_t notch;   ///< its number in the input
  plane::Point place;  ///< middle of the end: y and z [m]
  plane::Point ahead;  ///< unit vector out of the slot
  double half_height;  ///< [m]
};

/// Those of all slots. An open end is included: nothing is loaded there.
std::vector<SquareEnd> square_ends(const plane::Specimen& specimen);

/// Square ends up to this height, in spacings, are cracks; higher ones have corners of their own.
inline constexpr double highest_end_in_spacings = 1.5;
/// True if an end is higher.
bool is_high(const SquareEnd& end, const geometry::SpacingField& spacing, double thickness);

/// Nucleation and growth of cracks differ. At a crack, that is, for tetrahedra that share a node with a
/// broken one or lie at the square end of a narrow slot, a tetrahedron breaks by its own stress; if the input
/// gives a toughness too, at the threshold that gives it at the local spacing. Where there is no crack the
/// strength holds, for its own stress and the mean around a corner (NodalMeans).
///
/// By the own stress alone (input::Nucleation::own_stress), or one averaged over balls, every square end
/// counts as a crack, and where the toughness requires the higher threshold, that one holds everywhere.
///
/// In a dynamic phase a broken tetrahedron acts on those around it after the time in which a dilatational
/// wave, the fastest there is, crosses one spacing. Without this delay, tetrahedra whose stress lies between
/// the two thresholds would break one after another in each step, faster than any wave could unload them.
///
/// Follows the cracks of a body and changes the criterion's strengths accordingly.
class CrackVicinity {
public:
  /// Local.
  /// @param ends that count as cracks
  /// @param growth_strengths of each local tetrahedron at a crack [Pa]; empty: as where there is no crack;
  /// must
  ///   outlive the object
  /// @param average relative to the criterion's strengths, or nullptr
  /// @param spacings of the mesh at each local tetrahedron [m]
  /// @param by_means as input::Fracture::nucleates_by_means()
  CrackVicinity(const BreakableBody& body, Criterion& criterion, StressAverage* average,
                std::span<const double> growth_strengths, std::span<const SquareEnd> ends,
                std::span<const double> spacings, bool by_means);

  /// The means that must reach the strength beside the own stress, or nullptr.
  const NodalMeans* means() const { return means_ ? &*means_ : nullptr; }
  /// True if they must for a local tetrahedron now.
  bool needs_mean(std::int32_t tetrahedron) const { return means_ && reached_[index(tetrahedron)] == 0; }

  /// Takes over the broken tetrahedra that were not yet counted as a crack. Collective; does not call
  /// check_peers() before. A rank that fails before its communication throws; the others then do nothing.
  /// @param phase_time since the start of the dynamic phase [s]; infinity: all that is broken is a crack
  /// @return the local tetrahedra whose strength has changed, ascending
  std::span<const std::int32_t> update(const parallel::Communicator& group, double phase_time = infinity);

private:
  /// A broken tetrahedron that does not act on its surroundings yet.
  struct Arriving {
    std::int32_t tetrahedron;
    double broke_at;  // phase time [s]
  };
  void reach(std::int32_t tetrahedron);

  const BreakableBody* body_;
  Criterion* criterion_;
  StressAverage* average_;
  std::span<const double> growth_strengths_;
  std::vector<double> delays_;  // of each local tetrahedron [s]
  mechanics::NodeTetrahedra round_node_;
  std::optional<NodalMeans> means_;
  std::vector<std::uint8_t> reached_;   // of each local tetrahedron: 1 at a crack
  std::vector<std::uint8_t> at_crack_;  // of each local node
  std::size_t n_seen_ = 0;              // breaks counted by this rank
  std::vector<Arriving> arriving_;      // of these
  std::vector<std::int32_t> changed_;
};

}  // namespace crackle::fracture
