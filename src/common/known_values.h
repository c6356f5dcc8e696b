// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <set>

namespace crackle {

/// Values such as coordinates of planes, of which those that differ by rounding are one.
class KnownValues {
public:
  void insert(double value) { values_.insert(value); }

  /// The least known value within the tolerance; else the value itself, which is known from then on.
  double aligned(double value, double tolerance) {
    const auto near = values_.lower_bound(value - tolerance);
    if (near != values_.end() && *near <= value + tolerance) return *near;
    values_.insert(value);
    return value;
  }

private:
  std::set<double> values_;
};

}  // namespace crackle
