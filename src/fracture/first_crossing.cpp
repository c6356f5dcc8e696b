// SPDX-License-Identifier: GPL-3.0-or-later
#include "first_crossing.h"

#include <cmath>

namespace crackle::fracture {

namespace {

using mechanics::Symmetric;

double excess(const EquivalentStress& value, const Symmetric& stress, const Symmetric& rate, double strength,
              double s) {
  Symmetric sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = stress[i] + s * rate[i];
  return value(sum) - strength;
}

}  // namespace

double crossing(const EquivalentStress& value, const Symmetric& stress, const Symmetric& rate,
                double strength, double limit) {
  double upper = limit;
  if (std::isinf(upper)) {
    const double growth = value(rate);
    if (growth <= 0) return infinity;
    upper =
        2 *
        (strength + value.bound({-stress[0], -stress[1], -stress[2], -stress[3], -stress[4], -stress[5]})) /
        growth;
    upper = std::max(upper, 1e-300);
  }
  // The value is convex in s and starts below the strength, so it crosses at most once; found by bisection.
  // Close to the crossing rounding decides, so the last bits depend on the starting interval.
  if (excess(value, stress, rate, strength, upper) < 0) return infinity;
  double lower = 0;
  for (;;) {
    const double middle = 0.5 * (lower + upper);
    if (middle <= lower || middle >= upper) return upper;
    (excess(value, stress, rate, strength, middle) < 0 ? lower : upper) = middle;
  }
}

bool FirstCrossing::comes_later(const Symmetric& stress, const Symmetric& rate, double strength) const {
  const double target = std::min(value_, limit_);
  if (!std::isfinite(target)) return false;
  // Below the strength at 0 and at the target by more than rounding and hence, being convex, everywhere
  // between: any crossing lies beyond the target.
  const double slack =
      EquivalentStress::rounding(stress) + target * EquivalentStress::rounding(rate) + 1e-13 * strength;
  const double room = strength - of_->bound(stress);
  const double growth = std::max(0.0, of_->bound(rate));
  if (room - target * growth > slack) return true;
  const auto is_below = [&](double s) { return excess(*of_, stress, rate, strength, s) < -slack; };
  return is_below(target) && (room > slack || is_below(0));
}

double FirstCrossing::crossing_from(const Symmetric& stress, const Symmetric& rate, double strength) const {
  return (*of_)(stress) >= strength ? 0 : crossing(*of_, stress, rate, strength, limit_);
}

void FirstCrossing::take(double s, std::int64_t number) {
  if (s < value_ || (s == value_ && std::isfinite(s) && number < number_)) {
    value_ = s;
    number_ = number;
  }
}

void FirstCrossing::see(const Symmetric& stress, const Symmetric& rate, double strength,
                        std::int64_t number) {
  if (!comes_later(stress, rate, strength)) take(crossing(*of_, stress, rate, strength, limit_), number);
}

}  // namespace crackle::fracture
