// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "mechanics/tensor.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::dynamics {

/// Stresses of a few tetrahedra, or around a few nodes, computed on first use.
class StressCache {
public:
  /// @param n tetrahedra or nodes
  explicit StressCache(std::int32_t n) : place_(static_cast<std::size_t>(n), -1) {}

  void clear() {
    for (const auto i : known_) place_[index(i)] = -1;
    known_.clear();
    stress_.clear();
  }

  /// Valid until the next call.
  template <class Compute>
  const mechanics::Symmetric& get(std::int32_t i, const Compute& compute) {
    if (place_[index(i)] < 0) {
      stress_.push_back(compute(i));
      known_.push_back(i);
      place_[index(i)] = static_cast<std::int32_t>(known_.size()) - 1;
    }
    return stress_[index(place_[index(i)])];
  }

private:
  std::vector<std::int32_t> place_;  // of each one in stress_, or -1
  std::vector<std::int32_t> known_;
  std::vector<mechanics::Symmetric> stress_;
};

}  // namespace crackle::dynamics
