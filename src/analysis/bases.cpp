// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/bases.h"
#include "analysis/leader_frame.h"
#include "analysis/path_groups.h"
#include "analysis/result_list.h"
#include "common/failure.h"
#include "common/index.h"
#include "input/reader.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>

namespace crackle::analysis {

namespace {

using Value = std::function<double(const SampleSummary&)>;

void check(std::span<const BaseSamples> bases) {
  if (bases.size() < 2) fail("give the folders of two or more ensembles");
  for (std::size_t i = 0; i < bases.size(); ++i) {
    const input::Study& one = *bases[i].study;
    if (one.mesh.base != input::Base::shared)
      fail(
          "several folders are taken as several shared bases, but mesh.base is \"own\": these samples are "
          "independent already; use more of them, or crackle compare");
    if (!one.mesh.points_digest.empty())
      fail("several folders are taken as several shared bases, but mesh.points gives all of them the same");
    if (bases[i].settings != bases[0].settings)
      fail("the inputs of ensembles 1 and {} differ in more than ensemble.seed; use crackle compare", i + 1);
    for (std::size_t k = 0; k < i; ++k)
      if (bases[k].study->seed == one.seed)
        fail("ensembles {} and {} have the same seed, {}, and so the same base", k + 1, i + 1, one.seed);
  }
}

/// @return without values if no sample has any
MeanOverBases mean_over(std::span<const BaseSamples> bases, const Value& value, bool is_share,
                        double confidence) {
  MeanOverBases found;
  std::vector<double> values, means;
  double sum_of_inverses = 0;  // of the numbers of values
  std::vector<std::size_t> base;
  for (std::size_t i = 0; i < bases.size(); ++i) {
    double sum = 0;
    const std::size_t before = values.size();
    for (const SampleSummary& row : bases[i].rows) {
      if (row.status != SampleStatus::done || std::isnan(value(row))) continue;
      values.push_back(value(row));
      base.push_back(i);
      sum += values.back();
    }
    const auto n = static_cast<double>(values.size() - before);
    found.of_base.push_back(n > 0 ? sum / n : not_a_number);
    if (n > 0) means.push_back(sum / n);
    if (n > 0) sum_of_inverses += 1 / n;
  }
  found.n_values = static_cast<int>(values.size());
  if (means.empty()) return found;
  const auto [least, most] = std::ranges::minmax(values);
  if (least == most) {
    found.mean = {least, not_a_number, not_a_number, true};
    return found;
  }
  found.variance = variance_components(values, base);
  Moments moments;
  for (const double mean : means) moments.add(mean);
  found.mean.value = moments.mean();
  if (means.size() > 1) {
    double square_error = std::pow(moments.standard_deviation(), 2) / moments.count();
    // Shares of few samples may agree by chance.
    if (square_error == 0) square_error = found.variance.within * sum_of_inverses / std::pow(means.size(), 2);
    const double half_width = student_quantile(moments.count(), confidence) * std::sqrt(square_error);
    found.mean.lower = found.mean.value - half_width;
    found.mean.upper = found.mean.value + half_width;
  }
  if (is_share) {
    found.mean.lower = std::isnan(found.mean.lower) ? not_a_number : std::max(0.0, found.mean.lower);
    found.mean.upper = std::isnan(found.mean.upper) ? not_a_number : std::min(1.0, found.mean.upper);
  }
  return found;
}

/// For each section whether the leaders of a class, in all bases, are in groups.
std::vector<std::uint8_t> divided_leaders(std::span<const BaseSamples> bases, const LeaderFrame& frame,
                                          int start) {
  std::vector<std::vector<double>> paths;
  for (const BaseSamples& one : bases)
    for (const SampleSummary& row : one.rows) {
      auto& path = paths.emplace_back(index(frame.n_sections()), not_a_number);
      for (int s = 0; s < frame.n_sections() && row.status == SampleStatus::done; ++s)
        path[index(s)] = framed_position(frame, row, start, start, s).value;
    }
  return divided_sections(paths, path_groups(paths));
}

}  // namespace

BasesStatistics statistics_of_bases(std::span<const BaseSamples> bases, double confidence) {
  check(bases);
  BasesStatistics all{.confidence = confidence};
  for (const BaseSamples& one : bases) {
    all.seeds.push_back(one.study->seed);
    all.n_done.push_back(0);
    for (const SampleSummary& row : one.rows) {
      all.n_done.back() += row.status == SampleStatus::done ? 1 : 0;
      all.n_failed += row.status == SampleStatus::failed ? 1 : 0;
      all.n_pending += row.status == SampleStatus::pending ? 1 : 0;
      all.n_undecided += is_undecided(row) ? 1 : 0;
      all.n_unbroken += is_unbroken(row) ? 1 : 0;
      all.n_held += is_held(row) ? 1 : 0;
    }
  }
  const auto add = [&](MeanOverBases what, bool is_share, const Value& value) {
    MeanOverBases found = mean_over(bases, value, is_share, confidence);
    // A share of 0 or of 1 in all bases says nothing of them.
    if (found.n_values == 0 || (is_share && found.mean.has_no_width)) return;
    found.info = what.info;
    found.share_of = what.share_of;
    found.start = what.start;
    found.section = what.section;
    found.is_divided = what.is_divided;
    all.results.push_back(std::move(found));
  };
  for_each_result([&](const ResultInfo& info, auto member) {
    const bool is_pattern = std::string_view(info.name) == "pattern";
    const bool is_missing =
        std::ranges::any_of(bases, [&](const BaseSamples& one) { return lacks(one.origin, info.name); });
    if (is_missing || info.about == About::computation) return;
    if (is_pattern || info.reduction == Reduction::shares) {
      for (int k = 0; k < n_categories(info.categories); ++k)
        add({.info = info, .share_of = category_name(info.categories, k)}, true,
            [&](const SampleSummary& row) { return row.*member == k ? 1.0 : 0.0; });
    } else if (info.reduction == Reduction::counts) {
      const auto number = [&](const SampleSummary& row) { return known(info, member, row); };
      add({.info = info}, false, number);
      add({.info = info, .share_of = "any"}, true, [&](const SampleSummary& row) {
        return std::isnan(number(row)) ? not_a_number : number(row) > 0 ? 1.0 : 0.0;
      });
    } else if (info.reduction == Reduction::quantiles && info.about != About::place) {
      add({.info = info}, false, [&](const SampleSummary& row) { return known(info, member, row); });
    }
  });
  const input::Study& study = *bases[0].study;
  const LeaderFrame frame(study, study.sections);
  ResultInfo position{};
  for_each_position_result([&](const ResultInfo& info, auto) {
    if (std::string_view(info.name) == "position") position = info;
  });
  for (int start = 0; start < frame.n_starts(); ++start) {
    if (frame.reference()[index(start)] != start) continue;
    const std::vector<std::uint8_t> are_divided = divided_leaders(bases, frame, start);
    for (int s = 0; s < frame.n_sections(); ++s)
      add({.info = position, .start = start, .section = s, .is_divided = are_divided[index(s)] != 0}, false,
          [&](const SampleSummary& row) { return framed_position(frame, row, start, start, s).value; });
  }
  return all;
}

}  // namespace crackle::analysis
