// SPDX-License-Identifier: GPL-3.0-or-later
#include "text_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace crackle::experiment {

namespace {

/// Samples named in a sentence; more are counted.
constexpr std::size_t max_named = 20;

}  // namespace

std::string readable(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
}

std::string named(const std::vector<std::uint64_t>& samples, std::string_view what) {
  const std::size_t n = std::min(samples.size(), max_named);
  return fmt::format("{} {} ({}{})", samples.size(), what,
                     fmt::join(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(n), ", "),
                     samples.size() > n ? ", ..." : "");
}

double largest_magnitude(std::initializer_list<double> values) {
  double largest = 0;
  for (const double value : values)
    if (!std::isnan(value)) largest = std::max(largest, std::abs(value));
  return largest;
}

}  // namespace crackle::experiment
