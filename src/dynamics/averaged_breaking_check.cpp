// SPDX-License-Identifier: GPL-3.0-or-later
#include "averaged_breaking_check.h"

#include "crackle/common/index.h"
#include "crackle/parallel/collectives.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace crackle::dynamics {

namespace {

/// An average below this share of the strength was not above it a step before: it changes in the time in
/// which waves cross the ball, many steps.
constexpr double steady_share = 0.8;

}  // namespace

void StressCache::clear() {
  for (const auto t : known_) place_[index(t)] = -1;
  known_.clear();
  stress_.clear();
}

AveragedBreakingCheck::AveragedBreakingCheck(const MotionContext& context, MovingBody& motion)
    : context_(&context),
      motion_(&motion),
      stresses_{StressCache(context.body->subdomain().n_tetrahedra()),
                StressCache(context.body->subdomain().n_tetrahedra()),
                StressCache(context.body->subdomain().n_tetrahedra())} {}

void AveragedBreakingCheck::start() {
  for (auto& stresses : stresses_) stresses.clear();
  over_.clear();
  for (const auto t : motion_->overloaded())
    if (own_load(t, 0) > 1) over_.push_back(t);
}

std::span<const std::int32_t> AveragedBreakingCheck::end_step() {
  auto claims = parallel::gather_found<Claim>(*context_->group, [&] { return find_claims(); });
  // The most loaded of each tetrahedron first.
  std::ranges::sort(claims, [](const Claim& a, const Claim& b) {
    return a.tetrahedron != b.tetrahedron ? a.tetrahedron < b.tetrahedron : a.load > b.load;
  });
  breaking_.clear();
  std::int64_t last = -1;
  for (const auto& [number, load] : claims) {
    if (std::exchange(last, number) == number) continue;
    const std::int32_t t = context_->body->subdomain().local_number(number);
    if (t < 0) continue;
    const auto place = static_cast<std::size_t>(t);
    const double strength = context_->criterion->strength(place);
    if (context_->criterion->advance(place, load[2] * strength, load[1] * strength, load[0] * strength))
      breaking_.push_back(t);
  }
  return breaking_;
}

std::vector<AveragedBreakingCheck::Claim> AveragedBreakingCheck::find_claims() {
  for (auto& stresses : stresses_) stresses.clear();
  near_.clear();
  // One whose stress has fallen was above the strength for a part of the step.
  std::ranges::set_union(over_, motion_->overloaded(), std::back_inserter(near_));
  over_.clear();
  candidates_.clear();
  const auto& subdomain = context_->body->subdomain();
  for (const auto t : near_) {
    if (context_->body->is_broken(t)) continue;
    if (own_load(t, 0) > 1) over_.push_back(t);
    const std::int32_t centre = context_->average->centre(t);
    if (subdomain.counted[index(centre)] != 0) candidates_.push_back({centre, t});
  }
  std::ranges::sort(candidates_);
  std::vector<Claim> claims;
  for (auto begin = candidates_.begin(), end = begin; begin != candidates_.end(); begin = end) {
    const std::int32_t centre = begin->centre;
    end = std::find_if(begin, candidates_.end(), [&](const Candidate& one) { return one.centre != centre; });
    const std::span<const Candidate> of_cell(begin, end);
    std::array<double, 3> loads{load(of_cell, 0), 0, 0};
    if (loads[0] < steady_share) continue;
    for (int n = 1; n < 3; ++n) loads[index(n)] = load(of_cell, n);
    if (std::max(loads[0], loads[1]) < context_->screening_share) continue;
    const auto most = context_->average->most_stressed(
        centre, context_->criterion->stress(), [&](std::int32_t t) -> const auto& { return stress(t, 0); });
    claims.push_back({subdomain.tetrahedron_number[index(most)], loads});
  }
  return claims;
}

double AveragedBreakingCheck::load(std::span<const Candidate> candidates, int n_steps) {
  double own = 0;
  for (const auto& candidate : candidates) own = std::max(own, own_load(candidate.tetrahedron, n_steps));
  const auto mean = (*context_->average)(
      candidates.front().centre, [&](std::int32_t t) -> const auto& { return stress(t, n_steps); });
  return std::min(own, context_->criterion->stress()(mean));
}

const mechanics::Symmetric& AveragedBreakingCheck::stress(std::int32_t tetrahedron, int n_steps) {
  return stresses_[index(n_steps)].get(tetrahedron, [&](std::int32_t t) {
    return context_->body->elasticity()(n_steps == 0 ? motion_->strain(t)
                                                     : motion_->strain_before(t, n_steps));
  });
}

double AveragedBreakingCheck::own_load(std::int32_t tetrahedron, int n_steps) {
  return context_->criterion->stress()(stress(tetrahedron, n_steps)) /
         context_->criterion->strength(static_cast<std::size_t>(tetrahedron));
}

}  // namespace crackle::dynamics
