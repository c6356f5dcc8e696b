// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::parallel {

/// A sum of doubles that is independent of the order of its terms and of their distribution over ranks.
///
/// Every term is added without rounding to a fixed-point number that spans the whole range of a double (a
/// small superaccumulator, Kulisch 2008); only value() rounds. Thus energies, areas and dot products are
/// bitwise equal for every numbering and partition.
class ExactSum {
public:
  /// @throws std::domain_error for a term that is not finite
  void add(double term);

  /// The sum, rounded to a double (error below one unit in the last place).
  double value() const;

  /// Adds the sums of all ranks, in place. Collective.
  void all_reduce(const Communicator& group);

  /// exact_sums() of all ranks' terms.
  static std::vector<double> of_each(const Communicator& group, std::span<const std::vector<double>> terms);

private:
  // Digit d counts multiples of 2^(32 d - 1074). Digits have 32 bits plus 31 bits for carries.
  static constexpr int n_digits = 68;
  void carry();
  std::array<std::int64_t, n_digits> digit_{};
  std::int64_t terms_since_carry_ = 0;
};

/// The sum of all ranks' integers, rounded to a double: equal on every rank. Collective; does not call
/// check_peers() before.
double integer_sum(const Communicator& group, __int128 mine);

/// The sum of all ranks' terms, equal on every rank. Collective.
/// @throws AgreedError on every rank when a term is not finite
double exact_sum(const Communicator& group, std::span<const double> terms);

/// Several such sums in one reduction. Collective.
/// @param terms of each sum; every rank has the same number of sums
/// @throws AgreedError on every rank when a term is not finite
std::vector<double> exact_sums(const Communicator& group, std::span<const std::vector<double>> terms);

/// The sum of all ranks' products a[i] b[i], each rounded once, equal on every rank. Collective.
/// @throws AgreedError on every rank when a product is not finite
double exact_dot(const Communicator& group, std::span<const double> a, std::span<const double> b);

}  // namespace crackle::parallel
