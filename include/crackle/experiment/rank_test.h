// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/real.h"
#include "crackle/experiment/distances.h"

#include <cstddef>
#include <vector>

/// Tests of one experiment against samples. If it comes from their distribution, it is exchangeable with
/// them, and p-values are valid for any number of samples: at most alpha in a share alpha of cases.
namespace crackle::experiment {

/// Smallest p-value that n samples can give.
inline double least_p_value(std::size_t n_samples) {
  return 1 / static_cast<double>(n_samples + 1);
}

/// Samples needed for a p-value of `level`: 19 for 0.05.
std::size_t samples_needed(double level);

/// Share of the rows whose mean distance to the others is at least that of row 0, which counts.
double rank_p_value(const Distances& distances);

/// The band that holds a curve drawn like the others as a whole: at all columns at once.
///
/// Each row has a rank in each column, from above or below, whichever is smaller, made continuous by the
/// distances to its neighbours. The rows are ordered by their least rank and by how long and how far they are
/// there (area measure; Myllymäki and Mrkvička 2024, J. Stat. Softw. 111(3)); the band is the hull of those
/// that remain without the most extreme ones. The extreme rank length (Myllymäki et al. 2017, J. R. Stat.
/// Soc. B 79, 381) sees no distances: of 40 rows, two of which may be left out, it does not see one that is
/// far from all others in a third of the columns, since others are first or last in more of them.
///
/// In columns that some rows do not reach, these share a rank of their own, which is as extreme as they are
/// few.
struct Envelope {
  double level = not_a_number;       ///< confidence; that asked for, or less with few rows
  double p_value = 1;                ///< of row 0: share of the rows that are as extreme
  std::vector<double> lower, upper;  ///< of each column; NaN if none of the rows that remain gets there
  std::vector<bool> is_outside;      ///< row 0 there
};

/// @param confidence wanted; with fewer than 1 / (1 - confidence) rows only the most extreme row is left out
Envelope envelope(const ValueTable& table, double confidence);

}  // namespace crackle::experiment
