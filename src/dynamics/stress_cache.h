// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "mechanics/tensor.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace crackle::dynamics {

/// Stresses of a few tetrahedra, or around a few nodes, computed on first use.
class StressCache {
public:
  struct Kept {
    mechanics::Symmetric stress;       ///< [Pa]
    std::optional<double> value = {};  ///< of the equivalent stress, once somebody has found it [Pa]
  };

  /// @param n tetrahedra or nodes
  explicit StressCache(std::int32_t n) : place_(static_cast<std::size_t>(n), -1) {}

  void clear() {
    for (const auto i : known_) place_[index(i)] = -1;
    known_.clear();
    kept_.clear();
  }
  /// Forgets one of them.
  void drop(std::int32_t i) { place_[index(i)] = -1; }

  /// Valid until the next call.
  template <class Compute>
  Kept& get(std::int32_t i, const Compute& compute) {
    if (place_[index(i)] < 0) {
      kept_.push_back({compute(i)});
      known_.push_back(i);
      place_[index(i)] = static_cast<std::int32_t>(known_.size()) - 1;
    }
    return kept_[index(place_[index(i)])];
  }

private:
  std::vector<std::int32_t> place_;  // of each one in kept_, or -1
  std::vector<std::int32_t> known_;
  std::vector<Kept> kept_;
};

}  // namespace crackle::dynamics
