// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/random.h"
#include "crackle/geometry/point.h"

#include <span>
#include <vector>

namespace crackle::fracture {

/// A Gaussian random field of mean 0 and variance 1 in space, whose correlation at a distance r is Matern's
/// with smoothness 3/2: (1 + s) exp(-s), s = sqrt(3) r / correlation_length.
///
/// A sum of plane waves with random wave vectors from the spectrum and random Rayleigh amplitudes and phases
/// (Shinozuka; Mantoglou and Wilson 1982): at every point it is exactly normal, over all fields its
/// correlation is exact, and its value at a point depends neither on a mesh nor on who asks. Wave by wave
/// nothing but additions and multiplications is done at a point, so that all processors give the same bits
/// for the same waves.
class GaussianField {
public:
  /// @param correlation_length [m]
  /// @param n_waves the correlation within one field is that of the ensemble but for some 1 / sqrt(n_waves)
  GaussianField(RandomStream stream, double correlation_length, int n_waves = default_n_waves);

  /// The field's values at points [m].
  std::vector<double> at(std::span<const geometry::Point> points) const;

  static constexpr int default_n_waves = 512;

private:
  struct Wave {
    Vector turns;  ///< wave vector over 2 pi [1/m]
    double phase;  ///< in turns
    double amplitude;
  };
  std::vector<Wave> waves_;
};

/// (1 + s) exp(-s), s = sqrt(3) distance / correlation_length.
double matern_correlation(double distance, double correlation_length);

}  // namespace crackle::fracture
