// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/random.h"
#include "geometry/point.h"

#include <span>
#include <vector>

namespace crackle::fracture {

/// A Gaussian random field in space with mean 0, variance 1 and the Matern correlation of smoothness 3/2 at
/// distance r: (1 + s) exp(-s), s = sqrt(3) r / correlation_length.
///
/// A sum of plane waves with random wave vectors from the spectrum and random Rayleigh amplitudes and phases
/// (Shinozuka; Mantoglou and Wilson 1982): at every point it is exactly normal, its correlation over the
/// ensemble is exact, and its value at a point is independent of mesh and rank. The evaluation uses only
/// additions and multiplications, so all processors give the same bits for the same waves.
class GaussianField {
public:
  /// @param correlation_length [m]
  /// @param n_waves the correlation within one field differs from that of the ensemble by about 1 /
  ///   sqrt(n_waves)
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
