// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace crackle::fracture {

/// The Tuler-Butcher criterion (paper eq. 5): a tetrahedron breaks when the integral of
/// (sigma_1 - sigma_0)^beta over the time with sigma_1 > sigma_0 reaches K_f.
class TulerButcher {
public:
  TulerButcher(const input::Fracture& parameters, std::size_t n_tetrahedra)
      : parameters_(parameters), impulse_(n_tetrahedra, 0.0) {}

  double strength() const { return parameters_.strength; }

  /// Adds the contribution of one time step at whose end the largest principal stress is `stress`.
  /// @pre stress > strength()
  /// @return whether the tetrahedron breaks at the end of this step
  bool advance(std::size_t tetrahedron, double stress, double time_step) {
    const double contribution = rate(stress) * time_step;
    if (parameters_.memory == input::Memory::step) return contribution >= parameters_.impulse;
    impulse_[tetrahedron] += contribution;
    return impulse_[tetrahedron] >= parameters_.impulse;
  }

  /// Time to failure under constant stress from now on, without regard to earlier impulse [s].
  double time_to_failure(double stress) const {
    if (stress <= parameters_.strength) return std::numeric_limits<double>::infinity();
    return parameters_.impulse / rate(stress);
  }

  /// The integral so far of each tetrahedron.
  std::span<const double> impulse() const { return impulse_; }
  void set_impulse(std::size_t tetrahedron, double impulse) { impulse_[tetrahedron] = impulse; }

private:
  double rate(double stress) const {
    const double over = stress - parameters_.strength;
    return parameters_.exponent == 2 ? over * over : std::pow(over, parameters_.exponent);
  }

  input::Fracture parameters_;
  std::vector<double> impulse_;
};

}  // namespace crackle::fracture
