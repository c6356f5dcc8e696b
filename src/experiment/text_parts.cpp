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

std::string columns(const std::vector<Row>& rows) {
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (const Row& row : rows)
    for (std::size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  std::string text;
  for (const Row& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool is_left = c < 2 || c + 1 == row.size();
      line += fmt::format(fmt::runtime(is_left ? "{:<{}}  " : "{:>{}}  "), row[c], width[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string probability(double p) {
  if (std::isnan(p)) return "-";
  return p < 0.001 ? fmt::format("{:.1g}", p) : fmt::format("{:.3f}", p);
}

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

}  // namespace crackle::experiment
