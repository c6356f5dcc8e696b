// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/exceedance.h"

#include "common/failure.h"
#include "input/reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <vector>

namespace crackle::analysis {

Exceedance exceedance(const std::string& condition, std::span<const SampleSummary> rows, int replicates,
                      double confidence) {
  Exceedance found;
  const auto sign = condition.find_first_of("<>");
  const std::string_view all = condition;
  const auto trimmed = [](std::string_view text) {
    const auto first = text.find_first_not_of(' ');
    return first == std::string_view::npos
               ? std::string()
               : std::string(text.substr(first, text.find_last_not_of(' ') - first + 1));
  };
  const std::string name = trimmed(all.substr(0, sign));
  CensoredValues values;
  bool is_known = false;
  std::vector<std::string> names;
  for_each_result([&](const ResultInfo& info, auto member) {
    if (info.is_nominal()) return;
    names.emplace_back(info.name);
    if (name != info.name) return;
    found.info = info;
    is_known = true;
    values = observations(info, member, rows, replicates);
    found.n_undecided = static_cast<int>(std::ranges::count_if(rows, [&](const SampleSummary& row) {
      return is_undecided(row) && !std::isnan(observed(info, member, row).value);
    }));
  });
  if (sign == std::string::npos || condition.find('=') != std::string::npos)
    fail("'{}' is not a condition with < or >; give one such as \"peak_load > 500 N\"", condition);
  if (!is_known) fail("there is no result '{}'; give one of {}", name, fmt::join(names, ", "));
  found.is_above = condition[sign] == '>';
  found.limit = input::read_value(trimmed(all.substr(sign + 1)), found.info.units);

  found.n_planned = static_cast<int>(rows.size());
  found.n_failed = static_cast<int>(std::ranges::count(rows, SampleStatus::failed, &SampleSummary::status));
  found.n_missing = static_cast<int>(std::ranges::count(rows, SampleStatus::pending, &SampleSummary::status));
  found.n_values = static_cast<int>(values.size());
  found.n_bounds = values.n_bounds();
  found.n_without = found.n_planned - found.n_failed - found.n_missing - found.n_values;
  if (found.n_values > 0) found.share = censored_share(values, found.limit, found.is_above, confidence);
  return found;
}

std::string to_text(const Exceedance& found) {
  const std::string_view units = found.info.units;
  std::string text = fmt::format("{} {} {:g}{}{}: ", found.info.name, found.is_above ? '>' : '<', found.limit,
                                 units.empty() || units == "1" ? "" : " ", units == "1" ? "" : units);
  auto out = std::back_inserter(text);
  const CensoredShare& share = found.share;
  const auto interval = [&] {
    return fmt::format("({:.1f} to {:.1f} %)", 100 * share.interval.lower, 100 * share.interval.upper);
  };
  if (found.n_values == 0)
    text += "no sample has this result";
  else if (share.n_unknown == 0)
    fmt::format_to(out, "{} of {} samples, {:.1f} % {}{}", share.n_hits, found.n_values, 100 * share.share,
                   interval(),
                   found.n_bounds > 0 ? fmt::format(", {} of them by lower bounds", found.n_bounds) : "");
  else if (std::isnan(share.share))
    fmt::format_to(out, "{:.1f} to {:.1f} % of {} samples {}: {} bore all that was applied, which was less",
                   100 * share.least, 100 * share.most, found.n_values, interval(), share.n_unknown);
  else
    fmt::format_to(out,
                   "{:.1f} % of {} samples {} by Kaplan and Meier's estimate: {} are known to be, of {} "
                   "only lower bounds are known",
                   100 * share.share, found.n_values, interval(), share.n_hits, share.n_unknown);
  if (found.n_undecided > 0) fmt::format_to(out, ", {} of them undecided", found.n_undecided);
  text += '\n';
  const int n_others = found.n_planned - found.n_values;
  if (n_others == 0) return text;
  fmt::format_to(out,
                 "  of {} planned {} failed, {} are missing and {} have no such result: ", found.n_planned,
                 found.n_failed, found.n_missing, found.n_without);
  const auto percent = [&](int n) { return 100.0 * n / found.n_planned; };
  fmt::format_to(out,
                 "the share is not of them; with them it lies between {:.1f} and {:.1f} % of these samples\n",
                 percent(share.n_hits), percent(share.n_hits + share.n_unknown + n_others));
  return text;
}

}  // namespace crackle::analysis
