// SPDX-License-Identifier: GPL-3.0-or-later
#include "local_breaking_check.h"

#include "common/index.h"
#include "common/real.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <iterator>

namespace crackle::dynamics {

LocalBreakingCheck::LocalBreakingCheck(const MotionContext& context, MovingBody& motion)
    : context_(&context), motion_(&motion), means_(context.law->means()) {
  if (means_ == nullptr) return;
  stresses_.assign(n_times, StressCache(context.body->subdomain().n_tetrahedra()));
  of_nodes_.assign(n_times, StressCache(means_->n_patches()));
}

void LocalBreakingCheck::start() {
  for (auto& stresses : stresses_) stresses.clear();
  for (auto& stresses : of_nodes_) stresses.clear();
  breaking_.clear();
  over_.clear();
  for (const auto t : motion_->overloaded())
    if (exceeds(t, 0, context_->law->strength(index(t)))) over_.push_back(t);
}

std::span<const std::int32_t> LocalBreakingCheck::end_step(std::int64_t) {
  if (means_ == nullptr) {
    find_candidates();
  } else {
    const auto claims = parallel::gather_found<Claim>(*context_->group, [&] {
      find_candidates();
      return find_shared_means();
    });
    take_over(claims);
  }
  over_.clear();
  breaking_.clear();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const std::int32_t t = candidates_[i];
    if (breaks(i))
      breaking_.push_back(t);
    else if (exceeds(t, 0, context_->law->strength(index(t))))
      over_.push_back(t);
  }
  return breaking_;
}

/// A tetrahedron whose stress has dropped was above the strength for part of the step.
void LocalBreakingCheck::find_candidates() {
  // The last step's stresses are those of a step before, except for means over tetrahedra that have broken.
  for (auto* const caches : {&stresses_, &of_nodes_}) {
    if (caches->empty()) continue;
    std::ranges::rotate(*caches, caches->end() - 1);
    caches->front().clear();
  }
  for (auto& means : of_nodes_)
    for (const auto t : breaking_)
      for (std::size_t corner = 0; corner < 4; ++corner)
        if (const std::int32_t patch = means_->patch(t, corner); patch >= 0) means.drop(patch);
  candidates_.clear();
  std::ranges::set_union(over_, motion_->overloaded(), std::back_inserter(candidates_));
}

std::vector<LocalBreakingCheck::Claim> LocalBreakingCheck::find_shared_means() {
  std::vector<Claim> claims;
  shared_.assign(candidates_.size(), {-infinity, -infinity, -infinity});
  is_shared_.assign(candidates_.size(), 0);
  if (context_->group->size() == 1) return claims;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const std::int32_t t = candidates_[i];
    if (!needs_mean(t)) continue;
    bool is_shared = false;
    for (std::size_t corner = 0; corner < 4; ++corner) is_shared = is_shared || means_->patch(t, corner) < 0;
    if (!is_shared) continue;
    is_shared_[i] = 1;
    claims.push_back({context_->body->subdomain().tetrahedron_number[index(t)],
                      {largest_mean(t, 0), largest_mean(t, 1), largest_mean(t, 2)}});
  }
  return claims;
}

void LocalBreakingCheck::take_over(std::span<const Claim> claims) {
  for (const auto& [number, largest] : claims) {
    const std::int32_t t = context_->body->subdomain().local_number(number);
    if (t < 0) continue;
    const auto place = index(std::ranges::lower_bound(candidates_, t) - candidates_.begin());
    if (place == candidates_.size() || candidates_[place] != t) continue;  // another rank has failed
    for (std::size_t n = 0; n < largest.size(); ++n)
      shared_[place][n] = std::max(shared_[place][n], largest[n]);
  }
}

bool LocalBreakingCheck::breaks(std::size_t candidate) {
  const std::int32_t t = candidates_[candidate];
  fracture::FractureLaw& law = *context_->law;
  if (!needs_mean(t)) return law.advance(index(t), own(t, 2), own(t, 1), own(t, 0));
  const double limit = law.screening_share() * law.strength(index(t));
  const auto is_below = [&](std::size_t n_steps) {
    if (!exceeds(t, n_steps, limit)) return true;
    return is_shared_[candidate] != 0 ? shared_[candidate][n_steps] <= limit
                                      : !mean_exceeds(t, n_steps, limit);
  };
  if (is_below(0) && is_below(1)) return false;
  const auto value = [&](std::size_t n_steps) {
    return std::min(own(t, n_steps),
                    is_shared_[candidate] != 0 ? shared_[candidate][n_steps] : largest_mean(t, n_steps));
  };
  return law.advance(index(t), value(2), value(1), value(0));
}

bool LocalBreakingCheck::mean_exceeds(std::int32_t tetrahedron, std::size_t n_steps, double strength) {
  for (std::size_t corner = 0; corner < 4; ++corner)
    if (StressCache::Kept* const mean = this->mean(tetrahedron, corner, n_steps))
      if (context_->law->stress().exceeds(mean->stress, strength)) return true;
  return false;
}

double LocalBreakingCheck::largest_mean(std::int32_t tetrahedron, std::size_t n_steps) {
  double largest = -infinity;
  for (std::size_t corner = 0; corner < 4; ++corner)
    if (StressCache::Kept* const mean = this->mean(tetrahedron, corner, n_steps))
      if (mean->value || context_->law->stress().side(mean->stress, largest) >= 0)
        largest = std::max(largest, value(*mean));
  return largest;
}

StressCache::Kept* LocalBreakingCheck::mean(std::int32_t tetrahedron, std::size_t corner,
                                            std::size_t n_steps) {
  const std::int32_t patch = means_->patch(tetrahedron, corner);
  if (patch < 0) return nullptr;
  const auto stress_of = [&](std::int32_t t) -> const auto& {
    return kept(t, n_steps).stress;
  };
  return &of_nodes_[n_steps].get(patch,
                                 [&](std::int32_t) { return means_->at(tetrahedron, corner, stress_of); });
}

double LocalBreakingCheck::value(StressCache::Kept& kept) const {
  if (!kept.value) kept.value = context_->law->stress()(kept.stress);
  return *kept.value;
}

bool LocalBreakingCheck::exceeds(std::int32_t tetrahedron, std::size_t n_steps, double strength) {
  const fracture::EquivalentStress& value = context_->law->stress();
  return means_ != nullptr ? value.exceeds(kept(tetrahedron, n_steps).stress, strength)
                           : value.exceeds(stress(tetrahedron, n_steps), strength);
}

double LocalBreakingCheck::own(std::int32_t tetrahedron, std::size_t n_steps) {
  return means_ != nullptr ? value(kept(tetrahedron, n_steps))
                           : context_->law->stress()(stress(tetrahedron, n_steps));
}

mechanics::Symmetric LocalBreakingCheck::stress(std::int32_t tetrahedron, std::size_t n_steps) const {
  return context_->body->intact_stress(
      tetrahedron, n_steps == 0 ? motion_->strain(tetrahedron)
                                : motion_->strain_before(tetrahedron, static_cast<int>(n_steps)));
}

StressCache::Kept& LocalBreakingCheck::kept(std::int32_t tetrahedron, std::size_t n_steps) {
  return stresses_[n_steps].get(tetrahedron, [&](std::int32_t t) { return stress(t, n_steps); });
}

}  // namespace crackle::dynamics
