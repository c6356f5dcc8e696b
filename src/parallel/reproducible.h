// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"

#include <span>

namespace crackle::parallel {

/// The largest magnitude of all ranks' numbers; infinity if one is NaN. Collective; does not call
/// check_peers() before.
double largest_magnitude(const Communicator& group, std::span<const double> numbers);
double largest_magnitude(const Communicator& group, std::span<const float> numbers);

/// Dot product independent of the order of the terms and of their distribution over ranks: every product is
/// split into two integers on scales derived from the largest product of all ranks, and the integers are
/// summed. Its error is below 2^-70 n times the largest product. Far cheaper than ExactSum. Collective.
/// @pre fewer than 2^26 terms in total
/// @return NaN if a product is NaN, otherwise infinity if one is infinite
double reproducible_dot(MPI_Comm communicator, std::span<const double> a, std::span<const double> b);
/// The same for numbers whose products are exact.
double reproducible_dot(MPI_Comm communicator, std::span<const float> a, std::span<const float> b);
/// The same with an upper bound on this rank's products, which saves searching for the largest.
double reproducible_dot(MPI_Comm communicator, std::span<const float> a, std::span<const float> b,
                        double bound);

}  // namespace crackle::parallel
