// SPDX-License-Identifier: GPL-3.0-or-later
#include "mechanics/load_curve.h"

#include "common/interpolation.h"
#include "common/real.h"

#include <algorithm>

namespace crackle::mechanics {

double LoadCurve::at(double time) const {
  if (history_.empty()) return value_ + rate_ * time;
  return value_ * interpolated(history_, time);
}

double LoadCurve::slope(double time) const {
  if (history_.empty()) return rate_;
  for (std::size_t i = 1; i < history_.size(); ++i) {
    const auto [t0, f0] = history_[i - 1];
    const auto [t1, f1] = history_[i];
    if (time >= t0 && time < t1) return value_ * (f1 - f0) / (t1 - t0);
  }
  return 0;
}

double LoadCurve::slope(double time, const StepSpan& step) const {
  return has_kink(step) ? (at(step.end) - at(step.begin)) / (step.end - step.begin) : slope(time);
}

double LoadCurve::integral(double time) const {
  if (history_.empty()) return value_ * time + 0.5 * rate_ * time * time;
  double sum = 0;
  double from = 0;
  while (from < time) {
    const double to = std::min(time, next_kink(from));
    sum += 0.5 * (at(from) + at(to)) * (to - from);
    from = to;
  }
  return sum;
}

double LoadCurve::next_kink(double time) const {
  for (const auto& [t, factor] : history_) {
    if (t > time) return t;
  }
  return infinity;
}

bool LoadCurve::has_kink(const StepSpan& step) const {
  // The times of kicks at the end of the step may be rounded up.
  return next_kink(step.begin) <= step.end + 1e-6 * (step.end - step.begin);
}

}  // namespace crackle::mechanics
