// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/exceedance.h"

#include "crackle/analysis/grouped_values.h"
#include "crackle/common/failure.h"
#include "crackle/common/index.h"
#include "crackle/input/reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <functional>
#include <iterator>
#include <string_view>
#include <vector>

namespace crackle::analysis {

Exceedance exceedance(const std::string& condition, const input::Parameters& parameters,
                      std::span<const SampleSummary> rows, double confidence) {
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
  std::function<double(const SampleSummary&)> value;
  std::vector<std::string> names;
  for_each_result([&](const ResultInfo& info, auto member) {
    if (is_nominal(info)) return;
    names.emplace_back(info.name);
    if (name != info.name) return;
    found.info = info;
    value = [member](const SampleSummary& row) { return number_or_nan(row.*member); };
  });
  if (sign == std::string::npos)
    fail("'{}' is not a condition; give one such as \"peak_load > 500 N\"", condition);
  if (!value) fail("there is no result '{}'; give one of {}", name, fmt::join(names, ", "));
  found.is_above = condition[sign] == '>';
  found.limit = input::read_value(trimmed(all.substr(sign + 1)), found.info.units);

  found.n_planned = static_cast<int>(rows.size());
  std::vector<double> hits;
  std::vector<std::size_t> draws;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool is_done = rows[i].status == SampleStatus::done;
    found.n_failed += rows[i].status == SampleStatus::failed ? 1 : 0;
    found.n_missing += rows[i].status == SampleStatus::pending ? 1 : 0;
    found.n_without += is_done && std::isnan(value(rows[i])) ? 1 : 0;
    if (!is_done || std::isnan(value(rows[i]))) continue;
    found.n_undecided += is_undecided(rows[i]) ? 1 : 0;
    draws.push_back(index(parameters.ensemble.input_of(i)));
    hits.push_back((found.is_above ? value(rows[i]) > found.limit : value(rows[i]) < found.limit) ? 1 : 0);
    found.n_hits += hits.back() == 1 ? 1 : 0;
  }
  found.n_values = static_cast<int>(hits.size());
  if (hits.empty()) return found;
  found.share = static_cast<double>(found.n_hits) / found.n_values;
  found.interval = share_interval(hits, draws, confidence);
  return found;
}

std::string to_text(const Exceedance& found) {
  std::string text = fmt::format("{} {} {:g} {}: ", found.info.name, found.is_above ? '>' : '<', found.limit,
                                 found.info.units);
  auto out = std::back_inserter(text);
  if (found.n_values == 0)
    text += "no sample has this result";
  else
    fmt::format_to(out, "{} of {} samples, {:.1f} % ({:.1f} to {:.1f} %)", found.n_hits, found.n_values,
                   100 * found.share, 100 * found.interval.lower, 100 * found.interval.upper);
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
                 percent(found.n_hits), percent(found.n_hits + n_others));
  return text;
}

}  // namespace crackle::analysis
