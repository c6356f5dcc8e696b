// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/grouped_values.h"
#include "analysis/result_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

/// Shares and quantiles of values of which some are known by a lower bound only (right-censored), such as the
/// loads of samples that did not break, or were held. Bounds must not depend on the values that they bound,
/// as where all samples are loaded alike.
namespace crackle::analysis {

/// The number, NaN if only a bound is known.
inline double known(const Observation& one) {
  return one.is_bound ? not_a_number : one.value;
}

struct CensoredValues {
  std::vector<double> value;       ///< or the bound, above which the value lies
  std::vector<bool> is_bound;      ///< likewise
  std::vector<std::size_t> group;  ///< likewise, as Groups

  void add(const Observation& one, std::size_t of_group);
  std::size_t size() const { return value.size(); }
  int n_bounds() const { return static_cast<int>(std::ranges::count(is_bound, true)); }
};

/// False where bounds mean nothing, as samples broke, but none of them has the result: an onset after a start
/// from rest.
template <class Member>
bool has_bounds(const ResultInfo& info, Member member, std::span<const SampleSummary> rows) {
  const auto broke = [&](const SampleSummary& row) {
    return row.status == SampleStatus::done && !is_open(info, row);
  };
  return std::ranges::none_of(rows, broke) || std::ranges::any_of(rows, [&](const SampleSummary& row) {
           return broke(row) && !std::isnan(observed(info, member, row).value);
         });
}

/// The observations of a result in the samples that have it, by draws of the random inputs.
template <class Member>
CensoredValues observations(const ResultInfo& info, Member member, std::span<const SampleSummary> rows,
                            int replicates) {
  CensoredValues values;
  const bool with_bounds = has_bounds(info, member, rows);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (const Observation one = observed(info, member, rows[i]); with_bounds || !one.is_bound)
      values.add(one, i / static_cast<std::size_t>(replicates));
  return values;
}

/// Share of the values beyond a limit.
struct CensoredShare {
  double share = not_a_number;                    ///< NaN beyond the largest bound: known by `least`, `most`
  double least = 0, most = 1;                     ///< what the values allow, in the ensemble itself
  Interval interval{not_a_number, not_a_number};  ///< without the share: of what the values allow
  int n_hits = 0;                                 ///< values known to lie beyond the limit
  int n_unknown = 0;                              ///< whose bound is below the limit
};

/// The share of values above the limit or, unless `is_above`, below it. If no bound is below the limit, all
/// are known: a plain share with its share_interval. Otherwise the estimate of Kaplan and Meier (1958, J. Am.
/// Stat. Assoc. 53, 457) with Wilson's interval for the effective number of values (Rothman 1978, J. Chronic
/// Dis. 31, 557) from Greenwood's variance, by groups from that of Williams (1995, Lifetime Data Anal. 1,
/// 171).
/// @param values at least one
CensoredShare censored_share(const CensoredValues& values, double limit, bool is_above, double confidence);

/// Quantile and, by `median_bounds`, the ends of the interval of the median. Where the bounds are above all
/// other values: as of `quantile` and median_interval, in which they stand for the greatest values; otherwise
/// from the estimate of Kaplan and Meier (Brookmeyer and Crowley 1982, Biometrics 38, 29). What the values do
/// not tell is bounded by what it would be if the bounds were values. NaN without values.
Observation censored_quantile(const CensoredValues& values, double share);
std::array<Observation, 2> censored_median_interval(const CensoredValues& values, double confidence);

/// Scores that rank values of two lists among all of both: of how many values one is known to be the greater,
/// less of how many the smaller (Gehan 1965, Biometrika 52, 203). Of paired lists, differences of scores make
/// a test of pairs (O'Brien and Fleming 1987, Biometrics 43, 169).
/// @return of the first list, then of the second
std::array<std::vector<double>, 2> censored_scores(const CensoredValues& first, const CensoredValues& second);

}  // namespace crackle::analysis
