// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/breaking_check.h"
#include "crackle/fracture/stress_average.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Stresses of a few tetrahedra, computed when first asked for.
class StressCache {
public:
  explicit StressCache(std::int32_t n_tetrahedra) : place_(static_cast<std::size_t>(n_tetrahedra), -1) {}

  void clear();
  template <class Compute>
  const mechanics::Symmetric& get(std::int32_t tetrahedron, const Compute& compute) {
    auto& place = place_[index(tetrahedron)];
    if (place < 0) {
      stress_.push_back(compute(tetrahedron));
      known_.push_back(tetrahedron);
      place = static_cast<std::int32_t>(known_.size()) - 1;
    }
    return stress_[index(place)];
  }

private:
  std::vector<std::int32_t> place_;  // of each tetrahedron in stress_, or -1
  std::vector<std::int32_t> known_;
  std::vector<mechanics::Symmetric> stress_;
};

/// With the stress averaged over balls, one for each cell of a grid (fracture::StressAverage). Cells in which
/// no tetrahedron is near its own strength need no look. The criterion's damage belongs to what would break,
/// the ball's most stressed tetrahedron; of several balls that would break the same one, the most loaded
/// counts.
///
/// Averages change in the time in which waves cross a ball, many steps. So cells are looked at the more often
/// the nearer to the strength they are.
///
/// Each rank looks at the balls whose centres it counts, and tells the others what they would break.
class AveragedBreakingCheck final : public BreakingCheck {
public:
  /// @pre the context has an average
  AveragedBreakingCheck(const MotionContext& context, MovingBody& motion);

  void start() override {}
  std::span<const std::int32_t> end_step(std::int64_t step) override;

private:
  /// A ball's load on the tetrahedron that it would break: stress over strength.
  struct Claim {
    std::int64_t tetrahedron;    // in the realization
    std::array<double, 3> load;  // now, a step before, two steps before
  };

  /// A tetrahedron near its strength, in the cell that a ball stands for.
  struct Candidate {
    std::int32_t centre;
    std::int32_t tetrahedron;
    auto operator<=>(const Candidate&) const = default;
  };

  std::vector<Claim> find_claims(std::int64_t step);
  void find_candidates(std::span<const std::int32_t> tetrahedra);
  /// Of a ball: equivalent stress over strength.
  /// @param n_steps before now
  double load(std::int32_t centre, int n_steps);
  const mechanics::Symmetric& stress(std::int32_t tetrahedron, int n_steps);

  const MotionContext* context_;
  MovingBody* motion_;
  std::array<StressCache, 3> stresses_;  // now, a step before, two steps before
  // Near their own strength, in cells that were near it at the last look at all, and at the warm ones.
  std::vector<std::int32_t> warm_, hot_;
  std::vector<std::int32_t> breaking_;
  std::vector<Candidate> candidates_;
};

}  // namespace crackle::dynamics
