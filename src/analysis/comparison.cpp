// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/comparison.h"
#include "crackle/analysis/leader_frame.h"
#include "crackle/analysis/result_list.h"
#include "crackle/analysis/sensitivity.h"
#include "crackle/common/index.h"
#include "crackle/input/reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

namespace crackle::analysis {

namespace {

/// The input lines that determine the tessellated bodies of the samples.
std::vector<std::string> settings_of_bodies(const input::Parameters& parameters) {
  using enum input::Affects;
  std::vector<std::string> settings = input::settings_of(parameters, {body, points, mesh, draws});
  if (!parameters.mesh.points_digest.empty())
    settings.push_back("mesh.points with digest " + parameters.mesh.points_digest);
  return settings;
}

/// The first line of one list that is missing in the other, such as "mesh.spacing = 3 mm"; or empty.
std::optional<std::string> first_of_one_only(const std::vector<std::string>& one,
                                             const std::vector<std::string>& other) {
  for (const std::string& line : one)
    if (std::ranges::find(other, line) == other.end()) return line;
  return {};
}

bool is_done(const SampleSummary& row) {
  return row.status == SampleStatus::done;
}

/// A completed sample, and its draw of the random inputs.
struct Sample {
  const SampleSummary* row;
  std::size_t draw;
};

/// The samples of two ensembles to compare: those done or, for pairs, the pairs of which both are.
struct Samples {
  std::vector<Sample> first, second;
  bool are_paired;
};

Samples samples_of(const Compared& first, const Compared& second, bool are_paired) {
  Samples samples{{}, {}, are_paired};
  // A draw of both ensembles of pairs.
  const int of_pairs =
      std::max(first.parameters->ensemble.replicates, second.parameters->ensemble.replicates);
  const auto take = [&](const Compared& of, const Compared& other, std::vector<Sample>& list) {
    for (std::size_t i = 0; i < of.rows.size(); ++i)
      if (is_done(of.rows[i]) && (!are_paired || (i < other.rows.size() && is_done(other.rows[i]))))
        list.push_back({&of.rows[i], i / index(are_paired ? of_pairs : of.parameters->ensemble.replicates)});
  };
  take(first, second, samples.first);
  take(second, first, samples.second);
  return samples;
}

/// Lists such as TwoSamples of what the samples have; for pairs, of those where both have it.
/// @param read of a row, the value; empty if it has none
template <class Lists, class Read>
Lists lists_of(const Samples& samples, const Read& read) {
  Lists lists{{}, {}, samples.are_paired};
  const auto take = [&](const std::vector<Sample>& of, const std::vector<Sample>& other, auto& values,
                        std::vector<std::size_t>& groups) {
    for (std::size_t i = 0; i < of.size(); ++i) {
      auto value = read(*of[i].row);
      if (!value || (samples.are_paired && !read(*other[i].row))) continue;
      values.push_back(*std::move(value));
      groups.push_back(of[i].draw);
    }
  };
  take(samples.first, samples.second, lists.first, lists.first_group);
  take(samples.second, samples.first, lists.second, lists.second_group);
  return lists;
}

/// Lists of the numbers that are not NaN.
template <class Value>
TwoSamples values_of(const Samples& samples, const Value& value) {
  return lists_of<TwoSamples>(samples, [&](const SampleSummary& row) {
    const double found = value(row);
    return std::isnan(found) ? std::optional<double>() : found;
  });
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? not_a_number : sum / static_cast<double>(values.size());
}

/// Compares one number, or the share of one category.
ComparedResult compared(const ResultInfo& info, const std::string& share_of, const TwoSamples& samples,
                        double confidence) {
  ComparedResult result{.info = info, .share_of = share_of};
  result.n_first = static_cast<int>(samples.first.size());
  result.n_second = static_cast<int>(samples.second.size());
  result.mean_first = mean_of(samples.first);
  result.mean_second = mean_of(samples.second);
  if (share_of.empty()) {
    result.of_means = difference_of_means(samples, confidence);
    result.of_medians = difference_of_medians(samples, confidence);
  } else {
    result.of_means = difference_of_shares(samples, confidence);
  }
  result.probability =
      samples.first.empty() || samples.second.empty() ? not_a_number : permutation_probability(samples);
  return result;
}

/// Observations, as TwoSamples.
struct TwoObservations {
  std::vector<Observation> first, second;
  bool are_paired = false;
  std::vector<std::size_t> first_group = {}, second_group = {};
};

/// Compares one number of which unbroken samples give a lower bound.
/// @param scores receives the scores that are compared
ComparedResult compared(const ResultInfo& info, const TwoObservations& samples, double confidence,
                        TwoSamples& scores) {
  CensoredValues first, second;
  for (std::size_t i = 0; i < samples.first.size(); ++i) first.add(samples.first[i], samples.first_group[i]);
  for (std::size_t i = 0; i < samples.second.size(); ++i)
    second.add(samples.second[i], samples.second_group[i]);
  ComparedResult result{.info = info, .share_of = {}};
  result.n_first = static_cast<int>(first.size());
  result.n_second = static_cast<int>(second.size());
  result.n_bounds_first = first.n_bounds();
  result.n_bounds_second = second.n_bounds();
  result.median_first = censored_quantile(first, 0.5);
  result.median_second = censored_quantile(second, 0.5);
  result.of_medians = difference_of_medians(first, second, confidence);
  auto [one, other] = censored_scores(first, second);
  scores = {std::move(one), std::move(other), samples.are_paired, first.group, second.group};
  result.probability =
      first.size() == 0 || second.size() == 0 ? not_a_number : permutation_probability(scores);
  return result;
}

/// Comparisons, and what they compare.
struct Results {
  std::vector<ComparedResult> results;
  std::vector<TwoSamples> samples;
};

Results compare_results(const Samples& all, const Compared& first, const Compared& second,
                        double confidence) {
  Results found;
  for_each_result([&](const ResultInfo& info, auto member) {
    const bool is_pattern = std::string_view(info.name) == "pattern";
    if (lacks(first.origin, info.name) || lacks(second.origin, info.name) ||
        info.about == About::computation || info.about == About::place ||
        (info.reduction == Reduction::none && !is_pattern))
      return;
    const auto add = [&](const std::string& share_of, const auto& value) {
      TwoSamples samples = values_of(all, value);
      // A share of 0 or of 1 on both sides is not counted as a comparison.
      const auto is_one = [](double one) { return one == 1; };
      const auto n_ones =
          std::ranges::count_if(samples.first, is_one) + std::ranges::count_if(samples.second, is_one);
      const auto n = std::ssize(samples.first) + std::ssize(samples.second);
      if (n == 0 || (!share_of.empty() && (n_ones == 0 || n_ones == n))) return;
      found.results.push_back(compared(info, share_of, samples, confidence));
      found.samples.push_back(std::move(samples));
    };
    if (is_pattern || info.reduction == Reduction::shares) {
      for (int k = 0; k < n_categories(info.categories); ++k)
        add(category_name(info.categories, k),
            [&](const SampleSummary& row) { return row.*member == k ? 1.0 : 0.0; });
    } else if (info.reduction == Reduction::counts) {
      add("any", [&](const SampleSummary& row) { return row.*member > 0 ? 1.0 : 0.0; });
    } else {
      const auto observations = lists_of<TwoObservations>(all, [&](const SampleSummary& row) {
        const Observation one = observed(info, member, row);
        return std::isnan(one.value) ? std::optional<Observation>() : one;
      });
      const auto has_any = [](const std::vector<Observation>& list) {
        return std::ranges::any_of(list, &Observation::is_bound);
      };
      if (!has_bounds(info, member, first.rows) || !has_bounds(info, member, second.rows) ||
          !(has_any(observations.first) || has_any(observations.second)))
        return add("", [&](const SampleSummary& row) { return known(info, member, row); });
      found.results.push_back(compared(info, observations, confidence, found.samples.emplace_back()));
    }
  });
  return found;
}

struct Paths {
  std::vector<ComparedPaths> results;
  std::vector<TwoGroupsOfPaths> paths;
};

Paths compare_paths(const Samples& samples, const input::Parameters& parameters, double confidence) {
  const LeaderFrame frame(parameters);
  Paths all;
  for (int start = 0; start < frame.n_starts(); ++start) {
    if (frame.reference()[index(start)] != start) continue;
    const auto leads = [&](const SampleSummary& row) {
      return row.leading_start >= 0 && frame.reference()[index(row.leading_start)] == start;
    };
    auto paths = lists_of<TwoGroupsOfPaths>(samples, [&](const SampleSummary& row) {
      std::optional<std::vector<double>> path;
      if (!leads(row)) return path;
      path.emplace();
      for (int s = 0; s < frame.n_sections(); ++s)
        path->push_back(framed_position(frame, row, start, start, s).value);
      return path;
    });
    if (paths.first.empty() && paths.second.empty()) continue;
    ComparedPaths& found = all.results.emplace_back();
    found.leading_start = start;
    found.n_first = static_cast<int>(paths.first.size());
    found.n_second = static_cast<int>(paths.second.size());
    found.distance = energy_distance(paths);
    for (int s = 0; s < frame.n_sections(); ++s) {
      const TwoSamples positions = values_of(samples, [&](const SampleSummary& row) {
        return leads(row) ? framed_position(frame, row, start, start, s).value : not_a_number;
      });
      found.of_means.push_back(positions.first.empty() || positions.second.empty()
                                   ? Difference{}
                                   : difference_of_means(positions, confidence));
    }
    all.paths.push_back(std::move(paths));
  }
  return all;
}

void adjust(Comparison& comparison, std::span<const TwoSamples> samples,
            std::span<const TwoGroupsOfPaths> paths) {
  const JointTest joint = joint_test(samples, paths);
  comparison.n_looks = joint.n_looks;
  comparison.least = joint.least;
  // The joint permutations also change which samples lack a value; p alone does not.
  const auto adjusted = [&](double probability, std::size_t i) {
    return std::isnan(joint.adjusted[i]) ? not_a_number : std::max(joint.adjusted[i], probability);
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ComparedResult& result = comparison.results[i];
    result.adjusted = adjusted(result.probability, i);
    if (!samples[i].first.empty() && !samples[i].second.empty()) result.least = least_probability(samples[i]);
    if (joint.same_as[i] < 0) continue;
    const ComparedResult& same = comparison.results[index(joint.same_as[i])];
    result.same_as =
        same.share_of.empty() ? same.info.label : fmt::format("{}: {}", same.info.label, same.share_of);
  }
  for (std::size_t i = 0; i < paths.size(); ++i)
    comparison.paths[i].adjusted = adjusted(comparison.paths[i].distance.probability, samples.size() + i);
  if (joint.least > significant)
    comparison.remarks.push_back(fmt::format(
        "With so few samples no difference could be significant: the least p is {:.3f}.", joint.least));
  else if (joint.n_too_small > 0)
    comparison.remarks.push_back(
        joint.n_too_small == 1
            ? "One of the comparisons has too few samples for any p of 0.05 and is not counted."
            : fmt::format("{} of the comparisons have too few samples for any p of 0.05 and are not counted.",
                          joint.n_too_small));
}

SampleCounts counts_of(std::span<const SampleSummary> rows) {
  SampleCounts counts;
  for (const SampleSummary& row : rows) {
    counts.done += is_done(row) ? 1 : 0;
    counts.undecided += is_undecided(row) ? 1 : 0;
    counts.unbroken += is_unbroken(row) ? 1 : 0;
    counts.failed += row.status == SampleStatus::failed ? 1 : 0;
    counts.pending += row.status == SampleStatus::pending ? 1 : 0;
  }
  return counts;
}

/// Remarks on the base points that the numbers hold for.
void add_scope(Comparison& comparison, const Samples& samples, const Compared& first,
               const Compared& second) {
  const auto is_shared = [](const Compared& one) { return one.parameters->mesh.base == input::Base::shared; };
  comparison.has_shared_base = is_shared(first) || is_shared(second);
  if (comparison.has_shared_base)
    comparison.remarks.push_back(fmt::format(
        "Intervals and p-values hold for {} only (mesh.base = \"shared\"): with another base the answer may "
        "differ.",
        is_shared(first) && is_shared(second)
            ? "these base points"
            : fmt::format("the {} ensemble's base points", is_shared(first) ? "first" : "second")));
  const auto n_draws = [](const std::vector<Sample>& list) {
    std::size_t n = 0;
    for (std::size_t i = 0; i < list.size(); ++i) n += i == 0 || list[i].draw != list[i - 1].draw ? 1 : 0;
    return n;
  };
  if (std::max(first.parameters->ensemble.replicates, second.parameters->ensemble.replicates) > 1)
    comparison.remarks.push_back(
        fmt::format("Samples of one draw are not independent: intervals and p-values are by whole draws, {} "
                    "and {}.",
                    n_draws(samples.first), n_draws(samples.second)));
  const auto pair_of = [&](int SampleCounts::*member) {
    return fmt::format("{} in the first, {} in the second", comparison.first.*member,
                       comparison.second.*member);
  };
  const SampleCounts &one = comparison.first, &other = comparison.second;
  if (one.failed + other.failed > 0)
    comparison.remarks.push_back(
        fmt::format("Failed samples are in no number: {}.", pair_of(&SampleCounts::failed)));
  if (one.unbroken + other.unbroken > 0)
    comparison.remarks.push_back(fmt::format(
        "Some samples did not break ({}): loads count them as stronger than the largest applied, by "
        "medians (Kaplan and Meier) and p of Gehan's scores; times, displacements and work are of "
        "those that broke.",
        pair_of(&SampleCounts::unbroken)));
  if (one.undecided + other.undecided > 0)
    comparison.remarks.push_back(
        fmt::format("Undecided samples count with what they had reached, in all numbers: {}.",
                    pair_of(&SampleCounts::undecided)));
}

}  // namespace

Comparison compare(const Compared& first, const Compared& second, double confidence) {
  Comparison comparison;
  comparison.confidence = confidence;
  const auto one = settings_of_bodies(*first.parameters), other = settings_of_bodies(*second.parameters);
  const auto in_one = first_of_one_only(one, other), in_other = first_of_one_only(other, one);
  comparison.are_paired = !in_one && !in_other;
  const auto note = [&comparison](const std::string& text) {
    comparison.note += comparison.note.empty() ? text : "; " + text;
  };
  if (!comparison.are_paired)
    note(fmt::format("not paired, because the bodies differ: {} in one, {} in the other",
                     in_one.value_or("no such setting"), in_other.value_or("no such setting")));
  for (const std::string& text : std::set{note_on_plan(*first.parameters), note_on_plan(*second.parameters)})
    if (!text.empty()) note(text);
  const Samples samples = samples_of(first, second, comparison.are_paired);
  comparison.n_pairs = comparison.are_paired ? static_cast<int>(samples.first.size()) : 0;
  comparison.first = counts_of(first.rows);
  comparison.second = counts_of(second.rows);
  add_scope(comparison, samples, first, second);
  Results results = compare_results(samples, first, second, confidence);
  comparison.results = std::move(results.results);
  Paths paths;
  const auto specimen_of = [](const Compared& one) {
    return input::settings_of(*one.parameters, {input::Affects::body});
  };
  if (first.parameters->sections.all() != second.parameters->sections.all()) {
    note("paths are not compared, because the sections differ");
  } else if (specimen_of(first) != specimen_of(second)) {
    note("paths are not compared, because the bodies differ");
  } else {
    paths = compare_paths(samples, *first.parameters, confidence);
    comparison.paths = std::move(paths.results);
  }
  adjust(comparison, results.samples, paths.paths);
  return comparison;
}

}  // namespace crackle::analysis
