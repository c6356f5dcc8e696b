// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/input/parameters.h"

#include <cstddef>
#include <vector>

namespace crackle::fracture {

/// A saw-tooth softening law (Rots, Sequentially linear continuum model for concrete fracture, 2001): the
/// stiffness of a tetrahedron falls in steps, and with it the peaks of its stress, along a curve of stress
/// over opening, linear or exponential.
///
/// Everything is over the state in which the strength is reached: thresholds are in strengths of the stress
/// that the intact material would have at the same strain, so each is a multiple of the strain at first
/// softening; dissipated energies are over the strain energy at first softening. The peaks are 1, 1 - 1/n,
/// ..., 1/n of the strength. The curve is stretched as far as needed for the steps to dissipate exactly what
/// the curve should.
class SofteningLaw {
public:
  struct Tooth {
    double share;      ///< of the stiffness, until the tooth falls
    double threshold;  ///< at which it falls
  };

  /// @param n_teeth at least 2
  SofteningLaw(input::SofteningCurve curve, int n_teeth);

  /// The teeth of a tetrahedron, shares falling from 1, thresholds rising from 1.
  /// @param ductility energy that it dissipates over its strain energy at first softening. At 1 or less
  ///   softening would need more energy than it holds to be taken from it: it breaks at once.
  std::vector<Tooth> teeth(double ductility) const;

private:
  std::vector<Tooth> curve(double stretch) const;

  input::SofteningCurve curve_;
  int n_teeth_;
};

/// What teeth dissipate when the strain grows in proportion, over the energy at first softening.
double dissipation(const std::vector<SofteningLaw::Tooth>& teeth);

}  // namespace crackle::fracture
