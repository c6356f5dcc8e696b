// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

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

  /// Adds the contribution of one time step at whose end the largest principal stress is `stress`.
  /// @pre stress > strength(tetrahedron)
  /// @return whether the tetrahedron breaks at the end of this step
  bool advance(std::size_t tetrahedron, double stress) {
    if (parameters_.memory == input::Memory::step) return true;
    impulse_[tetrahedron] += rate(tetrahedron, stress) * time_step_;
    return impulse_[tetrahedron] >= parameters_.impulse;
  }

  /// Time to failure under constant stress from now on, without regard to earlier impulse [s]; infinity where
  /// it is over the strength by rounding only.
  double time_to_failure(std::size_t tetrahedron, double stress) const {
    if (stress <= strength_[tetrahedron] * (1 + rounding)) return std::numeric_limits<double>::infinity();
    if (parameters_.memory == input::Memory::step) return time_step_;
    return parameters_.impulse / rate(tetrahedron, stress);
  }

  /// The integral so far of each tetrahedron.
  std::span<const double> impulse() const { return impulse_; }
  void set_impulse(std::size_t tetrahedron, double impulse) { impulse_[tetrahedron] = impulse; }

private:
  static constexpr double rounding = 1e-5;  // of a stress from displacements in 32 bits, with room

  double rate(std::size_t tetrahedron, double stress) const {
    const double over = stress - strength_[tetrahedron];
    return parameters_.exponent == 2 ? over * over : std::pow(over, parameters_.exponent);
  }

  input::Fracture parameters_;
  double time_step_;
  std::vector<double> strength_;
  std::vector<double> impulse_;
};

}  // namespace crackle::fracture
