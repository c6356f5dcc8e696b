// SPDX-License-Identifier: GPL-3.0-or-later
#include "first_crossing.h"

#include "crackle/fracture/principal_stress.h"

#include <algorithm>
#include <cmath>

namespace crackle::fracture {

namespace {

using mechanics::Symmetric;

constexpr double infinity = std::numeric_limits<double>::infinity();
double excess(const Symmetric& stress, const Symmetric& rate, double strength, double s) {
  Symmetric sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = stress[i] + s * rate[i];
  return largest_principal(sum) - strength;
}

}  // namespace

double crossing(const Symmetric& stress, const Symmetric& rate, double strength, double limit) {
  double upper = limit;
  if (std::isinf(upper)) {
    const double growth = largest_principal(rate);
    if (growth <= 0) return infinity;
    upper = 2 *
            (strength + largest_principal_bound(
                            {-stress[0], -stress[1], -stress[2], -stress[3], -stress[4], -stress[5]})) /
            growth;
    upper = std::max(upper, 1e-300);
  }
  // The principal value is convex in s and starts below the strength, so it crosses once at most; by
  // bisection. Next to the crossing its rounding decides, so the last bits depend on where a bisection
  // starts.
  if (excess(stress, rate, strength, upper) < 0) return infinity;
  double lower = 0;
  for (;;) {
    const double middle = 0.5 * (lower + upper);
    if (middle <= lower || middle >= upper) return upper;
    (excess(stress, rate, strength, middle) < 0 ? lower : upper) = middle;
  }
}

void FirstCrossing::see(const Symmetric& stress, const Symmetric& rate, double strength,
                        std::int64_t number) {
  if (const double target = std::min(value_, limit_); std::isfinite(target)) {
    // Below the strength at 0 and at the target by more than rounding, and so, being convex, everywhere
    // between: the search would end behind the target, if anywhere.
    const double slack = principal_rounding(stress) + target * principal_rounding(rate) + 1e-13 * strength;
    const double room = strength - largest_principal_bound(stress);
    const double growth = std::max(0.0, largest_principal_bound(rate));
    if (room - target * growth > slack) return;
    const auto is_below = [&](double s) { return excess(stress, rate, strength, s) < -slack; };
    if (is_below(target) && (room > slack || is_below(0))) return;
  }
  const double s = crossing(stress, rate, strength, limit_);
  if (s < value_ || (s == value_ && std::isfinite(s) && number < number_)) {
    value_ = s;
    number_ = number;
  }
}

}  // namespace crackle::fracture
