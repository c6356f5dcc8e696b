// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

namespace crackle::parallel {

/// The largest magnitude among products. Bits of magnitudes are ordered as the magnitudes are, with those of
/// NaN above infinity: unlike a comparison of doubles, this loses no NaN, here or between ranks.
class LargestProduct {
public:
  void see(double product) {
    const auto bits = std::bit_cast<std::int64_t>(std::abs(product));
    if (bits > bits_) bits_ = bits;
  }
  std::int64_t bits() const { return bits_; }

private:
  std::int64_t bits_ = 0;
};

/// Dot product that does not depend on the order of the terms, nor on the ranks they lie on: every product is
/// split into two integers on scales that follow from the largest product of all ranks, and integers are
/// summed. Its error is below 2^-70 n times the largest product. Far cheaper than ExactSum. Collective.
/// @pre below 2^26 terms in all
/// @return NaN when a product is NaN, else infinity when one is infinite
double reproducible_dot(MPI_Comm communicator, std::span<const double> a, std::span<const double> b);
/// The same of numbers whose products are exact, where a bound of this rank's products is known.
double reproducible_dot(MPI_Comm communicator, std::span<const float> a, std::span<const float> b,
                        LargestProduct largest);

}  // namespace crackle::parallel
