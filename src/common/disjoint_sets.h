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
    // Nearly always the parent is the smallest already, and nothing is written.
    for (auto parent = parent_[i]; parent != i; parent = parent_[i]) {
      const auto next = parent_[parent];
      if (next != parent) parent_[i] = next;
      i = next;
    }
    return i;
  }

  void join(std::size_t a, std::size_t b) {
    // Nearly always they are together already.
    if (parent_[a] == parent_[b]) return;
    const std::size_t one = smallest(a), other = smallest(b);
    const auto [low, high] = std::minmax(one, other);
    parent_[high] = static_cast<std::uint32_t>(low);
  }

private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace crackle
