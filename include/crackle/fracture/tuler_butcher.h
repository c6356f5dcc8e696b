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
class TulerButcher {
public:
  /// @param strength of each tetrahedron [Pa]
  TulerButcher(const input::Fracture& parameters, std::vector<double> strength)
      : parameters_(parameters), strength_(std::move(strength)), impulse_(strength_.size(), 0.0) {}
  /// The input's strength everywhere.
  TulerButcher(const input::Fracture& parameters, std::size_t n_tetrahedra)
      : TulerButcher(parameters, std::vector<double>(n_tetrahedra, parameters.strength)) {}

  double strength(std::size_t tetrahedron) const { return strength_[tetrahedron]; }
  std::span<const double> strengths() const { return strength_; }

  /// Adds the contribution of one time step at whose end the largest principal stress is `stress`.
  /// @pre stress > strength(tetrahedron)
  /// @return whether the tetrahedron breaks at the end of this step
  bool advance(std::size_t tetrahedron, double stress, double time_step) {
    const double contribution = rate(tetrahedron, stress) * time_step;
    if (parameters_.memory == input::Memory::step) return contribution >= parameters_.impulse;
    impulse_[tetrahedron] += contribution;
    return impulse_[tetrahedron] >= parameters_.impulse;
  }

  /// Time to failure under constant stress from now on, without regard to earlier impulse [s].
  double time_to_failure(std::size_t tetrahedron, double stress) const {
    if (stress <= strength_[tetrahedron]) return std::numeric_limits<double>::infinity();
    return parameters_.impulse / rate(tetrahedron, stress);
  }

  /// The integral so far of each tetrahedron.
  std::span<const double> impulse() const { return impulse_; }
  void set_impulse(std::size_t tetrahedron, double impulse) { impulse_[tetrahedron] = impulse; }

private:
  double rate(std::size_t tetrahedron, double stress) const {
    const double over = stress - strength_[tetrahedron];
    return parameters_.exponent == 2 ? over * over : std::pow(over, parameters_.exponent);
  }

  input::Fracture parameters_;
  std::vector<double> strength_;
  std::vector<double> impulse_;
};

}  // namespace crackle::fracture
