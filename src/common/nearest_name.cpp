// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/nearest_name.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace crackle {

namespace {

/// Levenshtein distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string> nearest_name(const std::string& name, std::span<const std::string> known) {
  std::optional<std::string> nearest;
  std::size_t smallest = std::max<std::size_t>(2, name.size() / 3) + 1;
  for (const std::string& one : known) {
    const std::size_t distance = edit_distance(name, one);
    if (distance >= smallest || distance >= name.size()) continue;
    smallest = distance;
    nearest = one;
  }
  return nearest;
}

}  // namespace crackle
