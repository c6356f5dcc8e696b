// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"
#include "mechanics/elasticity.h"
#include "mechanics/tensor.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace crackle::fracture {

/// The scalar measure of stress that a criterion compares with a strength, such as the largest principal
/// stress.
///
/// It must be isotropic, convex and positively homogeneous (f(a sigma) = a f(sigma) for a >= 0): the search
/// for the first break under growing load and the bounds of the breaking check rely on this.
class EquivalentStress {
public:
  /// Factors of an upper bound: f(sigma) <= mean tr(sigma) / 3 + sqrt(j2 J2). For most tetrahedra the bound
  /// decides without evaluating f, also in the vectorized breaking check.
  struct Bound {
    double mean;
    double j2;  ///< non-negative
  };

  explicit EquivalentStress(Bound bound) : bound_(bound) {}
  virtual ~EquivalentStress() = default;

  /// Must be bitwise equal with every mathematical library.
  virtual double operator()(const mechanics::Symmetric& stress) const = 0;

  const Bound& bound_factors() const { return bound_; }

  double bound(const mechanics::Symmetric& s) const {
    const double mean = (s[0] + s[1] + s[2]) / 3;
    const double d0 = s[0] - mean, d1 = s[1] - mean, d2 = s[2] - mean;
    const double j2 = 0.5 * (d0 * d0 + d1 * d1 + d2 * d2) + s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    return bound_.mean * mean + std::sqrt(bound_.j2 * j2);
  }

  /// Tolerance far above the rounding errors of the value and its bound.
  static double rounding(const mechanics::Symmetric& s) {
    double sum = 0;
    for (const double component : s) sum += std::abs(component);
    return 1e-13 * sum;
  }

  /// Where the value surely is, found at less cost than the value: -1 below a level, 1 above it, 0 unknown.
  virtual int side(const mechanics::Symmetric& stress, double level) const {
    return bound(stress) < level - rounding(stress) ? -1 : 0;
  }

  /// True if the value exceeds `strength`.
  bool exceeds(const mechanics::Symmetric& stress, double strength) const {
    const int side = this->side(stress, strength);
    return side > 0 || (side == 0 && (*this)(stress) > strength);
  }

  /// The larger of a value and that of a stress.
  double larger(double value, const mechanics::Symmetric& stress) const {
    return side(stress, value) < 0 ? value : std::max(value, (*this)(stress));
  }

  /// A constant c that bounds the change of the value due to a strain sym(u b) by c |u| |b|. For this strain
  /// tr(sigma) / 3 is at most K |u| |b| and sqrt(J2) at most sqrt(4/3) mu |u| |b|.
  double sensitivity(const mechanics::IsotropicElasticity& elasticity) const {
    return std::abs(bound_.mean) * elasticity.bulk_modulus() + std::sqrt(bound_.j2 * 4 / 3) * elasticity.mu;
  }

private:
  Bound bound_;
};

/// Largest principal value of a symmetric tensor, by additions, multiplications, divisions and square roots
/// only, so that it is bitwise equal with every mathematical library.
double largest_principal(const mechanics::Symmetric& tensor);

/// Bounded by tr/3 + sqrt(4/3 J2), which is attained in uniaxial tension.
class LargestPrincipalStress final : public EquivalentStress {
public:
  LargestPrincipalStress();
  double operator()(const mechanics::Symmetric& stress) const override { return largest_principal(stress); }
  int side(const mechanics::Symmetric& stress, double level) const override;
};

/// The measure that the input selects.
std::unique_ptr<const EquivalentStress> make_equivalent_stress(const input::Fracture& fracture);

}  // namespace crackle::fracture
