// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"

#include "fixed_point_state.h"

#include "kernels/kernels.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace crackle::dynamics {

/// Access for the dampers, in quanta.
template <class Real>
struct DampedNodes {
  std::span<kernels::NodeRecord<Real>> nodes;
  std::span<kernels::Velocity<Real>> velocities;
  double half_drift;                     // displacement per velocity
  kernels::Movement<double> movement{};  // due to the changes

  double velocity(std::int32_t node, std::size_t c) const {
    return static_cast<double>(velocities[index(node)].value[c]);
  }
  double change(std::int32_t node, std::size_t c, double change) {
    const auto rounded = std::llrint(change);
    velocities[index(node)].value[c] += static_cast<kernels::Integer<Real>>(rounded);
    auto& place = nodes[index(node)].displacement[c];
    const auto displacement = std::llrint(static_cast<double>(rounded) * half_drift);
    place = low_digits<Real>(place + displacement);
    movement.low[c] = std::min(movement.low[c], static_cast<double>(displacement));
    movement.high[c] = std::max(movement.high[c], static_cast<double>(displacement));
    return static_cast<double>(rounded);
  }
};

/// Access for the viscous forces: velocities, in quanta.
template <class Real>
struct ViscousNodes {
  std::span<kernels::Velocity<Real>> velocities;
  bool& is_in_range;

  double velocity(std::int32_t node, std::size_t c) const {
    return static_cast<double>(velocities[index(node)].value[c]);
  }
  double change(std::int32_t node, std::size_t c, double change) {
    const auto rounded = quantized<kernels::Integer<Real>>(change, 1, is_in_range);
    auto& value = velocities[index(node)].value[c];
    if (__builtin_add_overflow(value, rounded, &value)) is_in_range = false;
    return static_cast<double>(rounded);
  }
};

}  // namespace crackle::dynamics
