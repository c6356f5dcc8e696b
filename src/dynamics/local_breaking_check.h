// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/breaking_check.h"

#include "stress_cache.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// Check with each tetrahedron's own stress and, where there is no crack, with the smaller of that and the
/// largest mean around one of its corners (fracture::NodalMeans). A mean is needed only for tetrahedra whose
/// own stress is near the strength.
///
/// All ranks that hold a tetrahedron reach the same decision: each contributes the means of the nodes that it
/// owns.
class LocalBreakingCheck final : public BreakingCheck {
public:
  LocalBreakingCheck(const MotionContext& context, MovingBody& motion);

  void start() override;
  std::span<const std::int32_t> end_step(std::int64_t step) override;

private:
  static constexpr std::size_t n_times = 3;
  /// A tetrahedron's stress now, a step before, two steps before [Pa].
  using Course = std::array<double, n_times>;
  /// The largest means of a tetrahedron around the corners that one rank owns.
  struct Claim {
    std::int64_t tetrahedron;  // number in the realization
    Course largest;
  };

  void find_candidates();
  std::vector<Claim> find_shared_means();
  void take_over(std::span<const Claim> claims);
  bool breaks(std::size_t candidate);
  // Both take the means around the corners that this rank owns.
  bool mean_exceeds(std::int32_t tetrahedron, std::size_t n_steps, double strength);
  double largest_mean(std::int32_t tetrahedron, std::size_t n_steps);
  /// Or nullptr if another rank owns the corner. Valid until the next call.
  StressCache::Kept* mean(std::int32_t tetrahedron, std::size_t corner, std::size_t n_steps);
  /// Its own stress exceeds a strength [Pa].
  bool exceeds(std::int32_t tetrahedron, std::size_t n_steps, double strength);
  double own(std::int32_t tetrahedron, std::size_t n_steps);
  double value(StressCache::Kept& kept) const;
  /// @param n_steps before now
  mechanics::Symmetric stress(std::int32_t tetrahedron, std::size_t n_steps) const;
  /// The same, kept until it is older than two steps. Valid until the next call.
  StressCache::Kept& kept(std::int32_t tetrahedron, std::size_t n_steps);
  bool needs_mean(std::int32_t tetrahedron) const { return context_->law->needs_mean(tetrahedron); }

  const MotionContext* context_;
  MovingBody* motion_;
  const fracture::NodalMeans* means_;  // or nullptr
  std::vector<StressCache> stresses_;  // now, a step before, two steps before; empty without means
  std::vector<StressCache> of_nodes_;  // likewise: the means
  std::vector<std::int32_t> over_;     // above the strength at the end of the last step; unbroken, ascending
  std::vector<std::int32_t> candidates_;  // ascending
  std::vector<Course> shared_;            // for each candidate, if several ranks own its corners
  std::vector<std::uint8_t> is_shared_;
  std::vector<std::int32_t> breaking_;
};

}  // namespace crackle::dynamics
