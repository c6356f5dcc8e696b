// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/equivalent_stress.h"

namespace crackle::fracture {

/// Largest principal value of a symmetric tensor, by additions, multiplications, divisions and square roots
/// only, so that it is bitwise equal with every mathematical library.
double largest_principal(const mechanics::Symmetric& tensor);

/// Bounded by tr/3 + sqrt(4/3 J2), which is attained in uniaxial tension.
class LargestPrincipalStress final : public EquivalentStress {
public:
  LargestPrincipalStress();
  double operator()(const mechanics::Symmetric& stress) const override { return largest_principal(stress); }
};

}  // namespace crackle::fracture
