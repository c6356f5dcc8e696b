// SPDX-License-Identifier: GPL-3.0-or-later
#include "averaged_breaking_check.h"

#include "common/index.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::dynamics {

namespace {

/// Cells with a load above these shares are checked in every step, or every few steps.
constexpr double hot_share = 0.85, warm_share = 0.6;
constexpr std::int64_t warm_interval = 4;
/// A cell below this share cannot have been above the strength one step before.
constexpr double steady_share = 0.95;
/// Far above the difference between a load by nodes and by tetrahedra.
constexpr double rounding = 1e-8;
/// Half a step ahead an extrapolated load exceeds the last ones by at most this many of their changes.
constexpr double look_ahead = 1.25;

}  // namespace

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
    const double strength = context_->law->strength(place);
    if (context_->law->advance(place, load[2] * strength, load[1] * strength, load[0] * strength))
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
  // The hot cells are the same until the next check of the warm ones, or the next break.
  const auto n_breaks = context_->body->broken_tetrahedra().size();
  if (checks_warm || step % warm_interval == 2 || n_breaks != n_breaks_seen_)
    find_candidates(checks_warm ? warm_ : hot_);
  n_breaks_seen_ = n_breaks;
  if (checks_all) warm_.clear();
  if (checks_warm) hot_.clear();
  std::vector<Claim> claims;
  for (auto begin = candidates_.begin(), end = begin; begin != candidates_.end(); begin = end) {
    const std::int32_t centre = begin->centre;
    end = std::find_if(begin, candidates_.end(), [&](const Candidate& one) { return one.centre != centre; });
    const double fast = fast_load(centre, 0);
    const auto keep_if_over = [&](double share, std::vector<std::int32_t>& kept) {
      if (!reaches(share, centre, fast)) return;
      for (auto one = begin; one != end; ++one) kept.push_back(one->tetrahedron);
    };
    if (checks_all) keep_if_over(warm_share, warm_);
    if (checks_warm) keep_if_over(hot_share, hot_);
    if (!reaches(steady_share, centre, fast)) continue;
    const double before = fast_load(centre, 1);
    if (std::max(fast, before) < context_->law->screening_share() - rounding) continue;
    // A criterion looks ahead by half a step, along a parabola through the last loads.
    const double change = std::max(std::abs(fast - before), std::abs(before - fast_load(centre, 2)));
    if (std::max(fast, before) + look_ahead * change < 1 - rounding) continue;
    const std::array<double, 3> loads{load(centre, 0), load(centre, 1), load(centre, 2)};
    if (std::max(loads[0], loads[1]) < context_->law->screening_share()) continue;
    const auto most = context_->law->average()->most_stressed(
        centre, context_->law->stress(), [&](std::int32_t t) -> const auto& { return stress(t, 0); });
    claims.push_back({context_->body->subdomain().tetrahedron_number[index(most)], loads});
  }
  return claims;
}

void AveragedBreakingCheck::find_candidates(std::span<const std::int32_t> tetrahedra) {
  candidates_.clear();
  for (const auto t : tetrahedra) {
    if (context_->body->is_broken(t)) continue;
    const std::int32_t centre = context_->law->average()->centre(t);
    if (context_->body->subdomain().owned[index(centre)] != 0) candidates_.push_back({centre, t});
  }
  std::ranges::sort(candidates_);
}

double AveragedBreakingCheck::load(std::int32_t centre, int n_steps) {
  return context_->law->stress()((*context_->law->average())(
      centre, [&](std::int32_t t) -> const auto& { return stress(t, n_steps); }));
}

double AveragedBreakingCheck::fast_load(std::int32_t centre, int n_steps) {
  // The average over nodes is that of the strain.
  if (context_->material_varies) return load(centre, n_steps);
  const auto& [nodes, gradients] = context_->law->average()->node_shares(centre);
  displacements_.resize(nodes.size());
  motion_->relative_displacements(nodes, n_steps, displacements_);
  mechanics::Symmetric sum{};
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const auto product = mechanics::symmetric_product(gradients[n], displacements_[n]);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += product[i];
  }
  return context_->law->stress()(context_->body->intact_stress(centre, sum));
}

bool AveragedBreakingCheck::reaches(double share, std::int32_t centre, double fast) {
  return std::abs(fast - share) > rounding ? fast > share : load(centre, 0) >= share;
}

const mechanics::Symmetric& AveragedBreakingCheck::stress(std::int32_t tetrahedron, int n_steps) {
  const auto compute = [&](std::int32_t t) {
    return context_->body->intact_stress(
        t, n_steps == 0 ? motion_->strain(t) : motion_->strain_before(t, n_steps));
  };
  return stresses_[index(n_steps)].get(tetrahedron, compute).stress;
}

}  // namespace crackle::dynamics
