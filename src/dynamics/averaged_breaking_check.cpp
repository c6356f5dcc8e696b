// SPDX-License-Identifier: GPL-3.0-or-later
#include "averaged_breaking_check.h"

#include "crackle/common/index.h"
#include "crackle/parallel/collectives.h"

#include <algorithm>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Cells with a load above these shares are checked in every step, or every few steps.
constexpr double hot_share = 0.85, warm_share = 0.6;
constexpr std::int64_t warm_interval = 4;
/// A cell below this share cannot have been above the strength one step before.
constexpr double steady_share = 0.95;

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

std::span<const std::int32_t> AveragedBreakingCheck::end_step(std::int64_t step) {
  auto claims = parallel::gather_found<Claim>(*context_->group, [&] { return find_claims(step); });
  // For each tetrahedron the most loaded claim first.
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

std::vector<AveragedBreakingCheck::Claim> AveragedBreakingCheck::find_claims(std::int64_t step) {
  for (auto& stresses : stresses_) stresses.clear();
  const bool checks_all = step % free_interval == 1, checks_warm = step % warm_interval == 1;
  if (checks_all) {
    const auto overloaded = motion_->overloaded();
    warm_.assign(overloaded.begin(), overloaded.end());
  }
  find_candidates(checks_warm ? warm_ : hot_);
  if (checks_all) warm_.clear();
  if (checks_warm) hot_.clear();
  std::vector<Claim> claims;
  for (auto begin = candidates_.begin(), end = begin; begin != candidates_.end(); begin = end) {
    const std::int32_t centre = begin->centre;
    end = std::find_if(begin, candidates_.end(), [&](const Candidate& one) { return one.centre != centre; });
    std::array<double, 3> loads{load(centre, 0), 0, 0};
    for (auto one = begin; one != end; ++one) {
      if (checks_all && loads[0] >= warm_share) warm_.push_back(one->tetrahedron);
      if (checks_warm && loads[0] >= hot_share) hot_.push_back(one->tetrahedron);
    }
    if (loads[0] < steady_share) continue;
    for (int n = 1; n < 3; ++n) loads[index(n)] = load(centre, n);
    if (std::max(loads[0], loads[1]) < context_->screening_share) continue;
    const auto most = context_->average->most_stressed(
        centre, context_->criterion->stress(), [&](std::int32_t t) -> const auto& { return stress(t, 0); });
    claims.push_back({context_->body->subdomain().tetrahedron_number[index(most)], loads});
  }
  return claims;
}

void AveragedBreakingCheck::find_candidates(std::span<const std::int32_t> tetrahedra) {
  candidates_.clear();
  for (const auto t : tetrahedra) {
    if (context_->body->is_broken(t)) continue;
    const std::int32_t centre = context_->average->centre(t);
    if (context_->body->subdomain().counted[index(centre)] != 0) candidates_.push_back({centre, t});
  }
  std::ranges::sort(candidates_);
}

double AveragedBreakingCheck::load(std::int32_t centre, int n_steps) {
  return context_->criterion->stress()((*context_->average)(
      centre, [&](std::int32_t t) -> const auto& { return stress(t, n_steps); }));
}

const mechanics::Symmetric& AveragedBreakingCheck::stress(std::int32_t tetrahedron, int n_steps) {
  return stresses_[index(n_steps)].get(tetrahedron, [&](std::int32_t t) {
    return context_->body->elasticity()(n_steps == 0 ? motion_->strain(t)
                                                     : motion_->strain_before(t, n_steps));
  });
}

}  // namespace crackle::dynamics
