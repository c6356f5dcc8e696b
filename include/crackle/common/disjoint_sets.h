// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace crackle {

/// A partition of 0..size-1 into sets that are joined two at a time. The smallest member represents its set,
/// so the result does not depend on the order of the joins.
class DisjointSets {
public:
  /// @param size below 2^32
  explicit DisjointSets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }

  /// The smallest member of the set that holds i.
  std::size_t smallest(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  /// @return the smallest member of the joined set
  std::size_t join(std::size_t a, std::size_t b) {
    const auto [low, high] = std::minmax({smallest(a), smallest(b)});
    parent_[high] = static_cast<std::uint32_t>(low);
    return low;
  }

private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace crackle
