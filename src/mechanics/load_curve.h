// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

namespace crackle::mechanics {

/// Start and end of a time step [s].
struct StepSpan {
  double begin = 0;
  double end = 0;
};

/// A prescribed function of time: value + rate t, or value times a piecewise linear factor.
class LoadCurve {
public:
  LoadCurve() = default;
  LoadCurve(double value, double rate, std::vector<std::pair<double, double>> history)
      : value_(value), rate_(rate), history_(std::move(history)) {}

  double at(double time) const;
  double slope(double time) const;  ///< right-sided derivative
  /// The slope at `time` in a step, or the mean over the step if it contains a kink: partial durations times
  /// slopes add up to the change over the step.
  double slope(double time, const StepSpan& step) const;
  double integral(double time) const;  ///< from 0 to time, exact
  /// First time after `time` at which the slope changes; infinity if there is none.
  double next_kink(double time) const;
  bool has_kink(const StepSpan& step) const;
  bool is_zero() const { return value_ == 0 && rate_ == 0; }

private:
  double value_ = 0;
  double rate_ = 0;
  std::vector<std::pair<double, double>> history_;
};

}  // namespace crackle::mechanics
