// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::fracture {

/// Tetrahedra of a sample's realization, or of a part of it.
struct TetrahedronSpan {
  std::span<const geometry::Point> nodes;             ///< [m]
  std::span<const geometry::Tetrahedron> tetrahedra;  ///< numbers in `nodes`
  std::span<const std::int64_t> number = {};          ///< in the realization; empty: in order, from 0
};

/// By how much the material is stronger than the input's strength, or tougher than its toughness, in each
/// tetrahedron: 1 without [fracture.variation].
///
/// Without a correlation length each tetrahedron draws its own Weibull factor, of the weakest place in its
/// volume V: (reference_volume / V)^(1/modulus) (-ln u)^(1/modulus). So a body under a smooth stress has the
/// same distribution of its strength on every mesh (Weibull 1939). With a correlation length the factor is
/// the value at the tetrahedron's centroid of a field that does not know the mesh: the distribution's
/// quantile at the probability of a GaussianField. The scale of the Weibull distribution and the mean of the
/// lognormal one are 1.
///
/// Depends on (seed, sample) and, without a correlation length, on the tetrahedron's number; rounded to 16
/// bits, since the last bits of logarithms and powers differ between processors.
std::vector<double> variation_factors(const input::Parameters& parameters, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra);

/// By what the strength of each tetrahedron of a sample's realization, or of a part of it, is multiplied: the
/// variation_factors where the strength varies, their roots where the toughness does, since a strength
/// criterion's toughness goes as the strength squared; with softening, which has both, 1 there.
std::vector<double> strength_factors(const input::Parameters& parameters, std::uint64_t sample,
                                     const TetrahedronSpan& tetrahedra);

/// By what the toughness of each tetrahedron is multiplied with softening: the variation_factors where it
/// varies, their squares where both do, and 1 where the strength does alone.
std::vector<double> toughness_factors(const input::Parameters& parameters, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra);

}  // namespace crackle::fracture
