// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace crackle::fracture {

/// The Tuler-Butcher criterion (paper eq. 5): a tetrahedron breaks when the integral of
/// (sigma_1 - sigma_0)^beta over the time with sigma_1 > sigma_0 reaches K_f.
///
/// With `memory = "step"` (the paper's "tau_f is the time step") only the last step's contribution counts. A
/// tetrahedron then breaks at once where sigma_1 exceeds sigma_0 + (K_f / step)^(1 / beta), and never below,
/// however slowly it is loaded: this is its strength. One that follows from a toughness is that limit itself.
class TulerButcher {
public:
  /// @param strength sigma_0 of each tetrahedron, or what follows from the input's toughness [Pa]
  /// @param time_step that advance() will be called with [s]
  TulerButcher(const input::Fracture& parameters, std::vector<double> strength, double time_step)
      : parameters_(parameters),
        time_step_(time_step),
        strength_(std::move(strength)),
        impulse_(strength_.size(), 0.0) {
    if (parameters.memory == input::Memory::cumulative || parameters.toughness > 0) return;
    const double over = std::pow(parameters.impulse / time_step, 1 / parameters.exponent);
    for (double& value : strength_) value += over;
  }
  /// The input's strength everywhere.
  TulerButcher(const input::Fracture& parameters, std::size_t n_tetrahedra, double time_step)
      : TulerButcher(parameters, std::vector<double>(n_tetrahedra, parameters.strength), time_step) {}

  /// The stress up to which the tetrahedron lasts for ever [Pa].
  double strength(std::size_t tetrahedron) const { return strength_[tetrahedron]; }
  std::span<const double> strengths() const { return strength_; }

  /// Adds the contribution of one time step, in which the largest principal stress goes from `before` to
  /// `after` in proportion to time.
  ///
  /// A tetrahedron can break at the end of a step only. It does so at the end that is nearest to the moment
  /// at which the integral reaches K_f: half a step too early or too late at most, and neither on average.
  /// What the stress comes to within the next half step is foreseen by the parabola through its last three
  /// values.
  /// @param earlier a step before `before`
  /// @return whether the tetrahedron breaks at the end of this step
  bool advance(std::size_t tetrahedron, double earlier, double before, double after) {
    const double from = before - strength_[tetrahedron], to = after - strength_[tetrahedron];
    if (parameters_.memory == input::Memory::step) return to > 0;
    double& impulse = impulse_[tetrahedron];
    impulse += time_step_ * mean_rate(from, to);
    const double next = to + (after - before) / 2 + 3 * ((after - before) - (before - earlier)) / 8;
    return impulse + time_step_ / 2 * mean_rate(to, next) >= parameters_.impulse;
  }

  /// The share of its strength above which a tetrahedron must be shown to advance() at the end of a step: one
  /// that is below its strength may be about to pass it and to break within half a step.
  /// @param stable_step in which a wave crosses the smallest tetrahedra [s]
  double watched_share(double stable_step) const {
    if (parameters_.memory == input::Memory::step) return 1;
    return 1 - fastest_rise * time_step_ / (2 * stable_step);
  }

  /// Time to failure under constant stress from now on, without regard to earlier impulse [s]; infinity where
  /// it is over the strength by rounding only.
  double time_to_failure(std::size_t tetrahedron, double stress) const {
    if (stress <= strength_[tetrahedron] * (1 + rounding)) return std::numeric_limits<double>::infinity();
    if (parameters_.memory == input::Memory::step) return time_step_;
    const double over = stress - strength_[tetrahedron];
    return parameters_.impulse / mean_rate(over, over);
  }

  /// The integral so far of each tetrahedron.
  std::span<const double> impulse() const { return impulse_; }
  void set_impulse(std::size_t tetrahedron, double impulse) { impulse_[tetrahedron] = impulse; }

private:
  static constexpr double rounding = 1e-5;  // of a stress from displacements in 32 bits, with room

  /// Of the stress at a crack front, in a stable step and over the strength. What rises faster breaks a
  /// little later.
  static constexpr double fastest_rise = 0.4;

  /// The mean of x^beta where x > 0, and of 0 elsewhere, over x from one value to the other.
  double mean_rate(double from, double to) const {
    const double low = std::min(from, to), high = std::max(from, to);
    if (!(high > 0)) return 0;
    const double share = low < 0 ? high / (high - low) : 1;  // of the time
    const double ratio = std::max(low, 0.0) / high;
    if (parameters_.exponent == 2) return share * high * high * ((1 + ratio + ratio * ratio) / 3);
    // (1 - ratio^n) / (1 - ratio), without the difference of nearly equal numbers
    const double n = parameters_.exponent + 1;
    const double sum = ratio == 1 ? n : std::expm1(n * std::log(ratio)) / (ratio - 1);
    return share * std::pow(high, parameters_.exponent) * (sum / n);
  }

  input::Fracture parameters_;
  double time_step_;
  std::vector<double> strength_;
  std::vector<double> impulse_;
};

}  // namespace crackle::fracture
