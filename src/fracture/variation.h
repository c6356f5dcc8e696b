// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/point.h"
#include "geometry/subdomain.h"
#include "input/material_model.h"

#include <cstdint>
#include <span>
#include <vector>

namespace crackle::fracture {

/// Tetrahedra of a sample's realization, or of part of it.
struct TetrahedronSpan {
  std::span<const geometry::Point> nodes;             ///< [m]
  std::span<const geometry::Tetrahedron> tetrahedra;  ///< numbers in `nodes`
  std::span<const std::int64_t> number = {};          ///< in the realization; empty: in order, from 0
  std::span<const std::uint8_t> material = {};        ///< number of the material; empty: the only one

  std::span<const float> map_factor = {};  ///< of the input's raster; empty without one

  /// Number of the material of one of them.
  std::size_t material_of(std::size_t tetrahedron) const {
    return material.empty() ? 0 : material[tetrahedron];
  }
};

inline TetrahedronSpan span_of(const geometry::Subdomain& subdomain) {
  return {subdomain.nodes, subdomain.tetrahedra, subdomain.tetrahedron_number, subdomain.material,
          subdomain.map_factor};
}

/// Factor of the input's strength or toughness in each tetrahedron: 1 without [fracture.variation].
///
/// Without a correlation length each tetrahedron draws its own Weibull factor, that of the weakest point in
/// its volume V: (reference_volume / V)^(1/modulus) (-ln u)^(1/modulus). Thus the strength distribution of a
/// body under smooth stress is mesh-independent (Weibull 1939). With a correlation length the factor is the
/// value at the tetrahedron's centroid of a mesh-independent field: the distribution's quantile at the
/// probability of a GaussianField. The scale of the Weibull distribution and the mean of the lognormal one
/// are 1.
///
/// Depends on (seed, sample) and, without a correlation length, on the tetrahedron's number; rounded to 16
/// bits, since the last bits of logarithms and powers differ between processors.
std::vector<double> variation_factors(const input::MaterialModel& model, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra);

/// Factor of the stiffness, the density or both of a material in each tetrahedron: 1 without
/// [material.variation]. The quantile of its distribution at the probability of a standard normal number: the
/// tetrahedron's own, or the value at its centroid of a GaussianField. With a correlation with the strength,
/// that number is a weighted sum with the one behind the factor of strength (a Gaussian copula). Rounded as
/// variation_factors().
/// @param material its number
std::vector<double> stiffness_factors(const input::MaterialModel& model, std::size_t material,
                                      std::uint64_t sample, const TetrahedronSpan& tetrahedra);

/// Factor of the strength of each tetrahedron of a sample's realization, or of part of it: the
/// variation_factors if the strength varies; their square roots if the toughness does, since the toughness of
/// a strength criterion is proportional to the strength squared. If the input gives both, which are then
/// independent, 1 in the latter case.
std::vector<double> strength_factors(const input::MaterialModel& model, std::uint64_t sample,
                                     const TetrahedronSpan& tetrahedra);

/// Factor of the toughness of each tetrahedron if the input gives both strength and toughness: the
/// variation_factors if it varies, their squares if both do, and 1 if only the strength does.
std::vector<double> toughness_factors(const input::MaterialModel& model, std::uint64_t sample,
                                      const TetrahedronSpan& tetrahedra);

}  // namespace crackle::fracture
