// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "dynamics/term.h"
#include "mechanics/fixed_point_scale.h"

#include "fixed_point_state.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::dynamics {

/// The nodes of a fixed-point state, for its terms. The quanta are powers of two, so that SI units cost no
/// digit.
template <class Real>
class FixedPointNodes final : public MovingNodes {
  using Integer = kernels::Integer<Real>;

public:
  /// @param mass of the owned nodes [kg]
  /// @param state must outlive the object
  FixedPointNodes(std::span<const double> mass, const mechanics::FixedPointScale& scale,
                  FixedPointState<Real>& state)
      : scale_(scale), state_(&state) {
    per_impulse_.reserve(mass.size());
    for (const double one : mass) per_impulse_.push_back(1 / (one * scale.velocity));
  }

  double displacement(std::int32_t node, int component) const override {
    return scale_.displacement *
           static_cast<double>(state_->whole_displacement(index(node), index(component)));
  }
  Vector whole_displacement(std::int32_t node) const override {
    return {displacement(node, 0), displacement(node, 1), displacement(node, 2)};
  }
  double velocity(std::int32_t node, int component) const override {
    return scale_.velocity * static_cast<double>(state_->velocity()[index(node)].value[component]);
  }
  double internal_force(std::int32_t node, int component) const override {
    return scale_.force * static_cast<double>(state_->nodes()[index(node)].force[component]);
  }

  void kick(std::int32_t node, int component, double duration, double force, double& remainder) override {
    const double change = duration * force * per_impulse_[index(node)] + remainder;
    const auto rounded = quantized<Integer>(change, 1, stays_in_range_);
    remainder = change - static_cast<double>(rounded);
    add(rounded, velocity_of(node, component));
  }
  double change_velocity(std::int32_t node, int component, double change, double duration) override {
    const auto rounded = quantized<Integer>(change, scale_.velocity, stays_in_range_);
    add(rounded, velocity_of(node, component));
    if (duration != 0) {
      auto& place = state_->nodes()[index(node)].displacement[component];
      const auto displacement =
          std::llrint(static_cast<double>(rounded) * (duration * scale_.velocity / scale_.displacement));
      place = low_digits<Real>(place + displacement);
      changed_.low[component] = std::min(changed_.low[component], static_cast<double>(displacement));
      changed_.high[component] = std::max(changed_.high[component], static_cast<double>(displacement));
    }
    return scale_.velocity * static_cast<double>(rounded);
  }
  void set_velocity(std::int32_t node, int component, double velocity) override {
    velocity_of(node, component) = quantized<Integer>(velocity, scale_.velocity, stays_in_range_);
  }
  void drive(std::int32_t node, int component, double displacement, double velocity, double drift) override {
    auto& place = state_->nodes()[index(node)].displacement[component];
    const Integer before = place;
    place = low_digits<Real>(quantized<std::int64_t>(displacement, scale_.displacement, stays_in_range_));
    set_velocity(node, component, velocity);
    // During the drift the node moved by the velocity at the start of the step; the sum bounds its movement.
    const double moved = std::abs(static_cast<double>(kernels::difference(place, before))) +
                         std::abs(drift * velocity) / scale_.displacement + 2;
    driven_.low[component] = std::min(driven_.low[component], -moved);
    driven_.high[component] = std::max(driven_.high[component], moved);
  }

  void add_balanced_forces(std::span<const std::int32_t> nodes, std::span<const Vector> forces) override {
    for (std::size_t k = 1; k < nodes.size(); ++k)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto force = quantized<Integer>(forces[k][i], scale_.force, forces_stay_in_range_);
        // The internal force acts with the opposite sign.
        if (nodes[k] >= 0) subtract(force, state_->nodes()[index(nodes[k])].force[i]);
        if (nodes[0] >= 0) subtract(-force, state_->nodes()[index(nodes[0])].force[i]);
      }
  }

  void movements(std::span<Vector> moved) const override {
    for (std::size_t n = 0; n < moved.size(); ++n) {
      const auto& before = state_->displacement_before(n, 1);
      for (std::size_t i = 0; i < 3; ++i)
        moved[n][i] = scale_.displacement *
                      static_cast<double>(kernels::difference(state_->nodes()[n].displacement[i], before[i]));
    }
  }
  double force_quantum() const override { return scale_.force; }

  /// True if every displacement and velocity has fitted the format so far.
  bool stay_in_range() const { return stays_in_range_; }
  bool forces_stay_in_range() const { return forces_stay_in_range_; }
  /// Extends a bound on the movement of nodes by what terms have moved since the last call, in quanta.
  void extend(kernels::Movement<double>& movement) {
    for (std::size_t c = 0; c < 3; ++c) {
      movement.low[c] = std::min(movement.low[c], driven_.low[c]) + changed_.low[c];
      movement.high[c] = std::max(movement.high[c], driven_.high[c]) + changed_.high[c];
    }
    driven_ = changed_ = {};
  }

private:
  Integer& velocity_of(std::int32_t node, int component) {
    return state_->velocity()[index(node)].value[component];
  }
  void add(Integer change, Integer& value) {
    if (__builtin_add_overflow(value, change, &value)) stays_in_range_ = false;
  }
  void subtract(Integer force, Integer& sum) {
    if (__builtin_sub_overflow(sum, force, &sum)) forces_stay_in_range_ = false;
  }

  mechanics::FixedPointScale scale_;
  FixedPointState<Real>* state_;
  std::vector<double> per_impulse_;  // change of velocity of each owned node [quanta / (N s)]
  kernels::Movement<double> driven_{}, changed_{};
  bool stays_in_range_ = true;
  bool forces_stay_in_range_ = true;
};

}  // namespace crackle::dynamics
