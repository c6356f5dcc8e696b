// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/breaking_check.h"
#include "fracture/stress_average.h"

#include "stress_cache.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Check with the stress averaged over balls, one for each cell of a grid (fracture::StressAverage). Cells in
/// which no tetrahedron is near its own strength are skipped. The criterion's damage is that of the ball's
/// most stressed tetrahedron, which would break; if several balls select the same tetrahedron, the most
/// loaded ball counts.
///
/// Averages change on the time scale of a wave crossing a ball, which is many steps. Hence cells are checked
/// more often the closer they are to the strength.
///
/// Each rank checks the balls whose centres it counts, and informs the others which tetrahedra they break.
class AveragedBreakingCheck final : public BreakingCheck {
public:
  /// @pre the context has an average
  AveragedBreakingCheck(const MotionContext& context, MovingBody& motion);

  void start() override {}
  std::span<const std::int32_t> end_step(std::int64_t step) override;

private:
  /// A ball's load (stress over strength) on the tetrahedron it would break.
  struct Claim {
    std::int64_t tetrahedron;    // number in the realization
    std::array<double, 3> load;  // now, a step before, two steps before
  };

  /// A tetrahedron near its strength, in the cell represented by a ball.
  struct Candidate {
    std::int32_t centre;
    std::int32_t tetrahedron;
    auto operator<=>(const Candidate&) const = default;
  };

  std::vector<Claim> find_claims(std::int64_t step);
  void find_candidates(std::span<const std::int32_t> tetrahedra);
  /// Load of a ball: equivalent stress over strength.
  /// @param n_steps before now
  double load(std::int32_t centre, int n_steps);
  /// The load by the ball's nodes, which is several times as fast and equal to load() up to rounding.
  double fast_load(std::int32_t centre, int n_steps);
  /// True if the current load() is at least `share`.
  /// @param fast the current fast_load()
  bool reaches(double share, std::int32_t centre, double fast);
  const mechanics::Symmetric& stress(std::int32_t tetrahedron, int n_steps);

  const MotionContext* context_;
  MovingBody* motion_;
  std::array<StressCache, 3> stresses_;  // now, a step before, two steps before
  // Candidates in cells that were near the strength at the last full check, and at the last check of warm
  // cells.
  std::vector<std::int32_t> warm_, hot_;
  std::vector<std::int32_t> breaking_;
  std::vector<Candidate> candidates_;  // in the cells to be checked, as of these breaks
  std::size_t n_breaks_seen_ = 0;
  std::vector<Vector> displacements_;  // of the nodes of a ball
};

}  // namespace crackle::dynamics
