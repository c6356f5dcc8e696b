// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/study.h"

#include <functional>
#include <vector>

namespace crackle::uncertainty {

/// The distribution of a random input's values [SI]. Its functions throw std::exception where they have no
/// value.
struct Distribution {
  std::function<double(double probability)> quantile;
  std::function<double(double value)> cdf;
  double corner = 0;  ///< probability at which the quantile is not smooth
  /// Values and shares whose sums are the integrals over the distribution; empty: a smooth one.
  std::vector<double> values = {}, shares = {};
};

Distribution distribution_of(const input::RandomInput& random);

}  // namespace crackle::uncertainty
