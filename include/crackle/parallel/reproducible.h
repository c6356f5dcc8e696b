// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"

#include <span>

namespace crackle::parallel {

/// The largest magnitude of all ranks' numbers; infinity where one is NaN. Collective; does not agree()
/// before.
double largest_magnitude(const Communicator& group, std::span<const double> numbers);
double largest_magnitude(const Communicator& group, std::span<const float> numbers);

/// Dot product that does not depend on the order of the terms, nor on the ranks they lie on: every product is
/// split into two integers on scales that follow from the largest product of all ranks, and integers are
/// summed. Its error is below 2^-70 n times the largest product. Far cheaper than ExactSum. Collective.
/// @pre below 2^26 terms in all
/// @return NaN when a product is NaN, else infinity when one is infinite
double reproducible_dot(MPI_Comm communicator, std::span<const double> a, std::span<const double> b);
/// The same of numbers whose products are exact.
double reproducible_dot(MPI_Comm communicator, std::span<const float> a, std::span<const float> b);
/// The same with a bound of this rank's products instead of the largest, which saves finding it.
double reproducible_dot(MPI_Comm communicator, std::span<const float> a, std::span<const float> b,
                        double bound);

}  // namespace crackle::parallel
