// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/path_inference.h"

#include "analysis/permutation_test.h"
#include "common/index.h"
#include "common/random.h"
#include "common/text_table.h"

#include <fmt/format.h>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace crackle::analysis {

namespace {

constexpr int n_multipliers = 4000;
constexpr int least_arrivals = 5;
constexpr int least_arrivals_of_jackknife = 3;

std::size_t n_sections_of(std::span<const FramedPath> paths) {
  return paths.empty() ? 0 : paths.front().size();
}

/// Sums of the groups' residuals at one section, relative to the root of the sum of their squares.
std::vector<double> relative_residuals(std::span<const FramedPath> paths, Groups groups, std::size_t section,
                                       double mean) {
  std::vector<double> sums;
  double squares = 0;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (i == 0 || group_of(groups, i) != group_of(groups, i - 1)) sums.push_back(0);
    const double value = paths[i][section].value;
    if (!std::isnan(value)) sums.back() += value - mean;
  }
  for (const double sum : sums) squares += sum * sum;
  for (double& sum : sums) sum /= std::sqrt(squares);
  return sums;
}

/// Confidence of each section's interval with which all hold together.
double confidence_of_sections(const std::vector<std::vector<double>>& residuals, double confidence) {
  if (residuals.size() < 2) return confidence;
  RandomStream stream(0, 0, "band of a path");
  std::vector<double> largest, multipliers(residuals.front().size());
  for (int k = 0; k < n_multipliers; ++k) {
    for (double& multiplier : multipliers) multiplier = stream.normal();
    double most = 0;
    for (const auto& section : residuals)
      most = std::max(most,
                      std::abs(std::inner_product(section.begin(), section.end(), multipliers.begin(), 0.0)));
    largest.push_back(most);
  }
  return 2 * boost::math::cdf(boost::math::normal(), quantile(largest, confidence)) - 1;
}

/// Position on the line of regression on the section before; empty with too few arrivals.
struct Regression {
  double mean_before = 0, mean = 0, slope = 0;

  double at(double before) const { return mean + slope * (before - mean_before); }
};

std::optional<Regression> regression(const std::vector<double>& before, const std::vector<double>& here,
                                     int least) {
  if (std::ssize(here) < least) return {};
  const auto n = static_cast<double>(here.size());
  Regression found;
  found.mean_before = std::accumulate(before.begin(), before.end(), 0.0) / n;
  found.mean = std::accumulate(here.begin(), here.end(), 0.0) / n;
  double square = 0, product = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    square += std::pow(before[i] - found.mean_before, 2);
    product += (before[i] - found.mean_before) * (here[i] - found.mean);
  }
  if (square > 0) found.slope = product / square;
  return found;
}

/// Sections such that each follows the one before it.
std::vector<std::size_t> in_order(std::span<const int> previous) {
  std::vector<std::size_t> order;
  std::vector<bool> is_listed(previous.size(), false);
  while (order.size() < previous.size()) {
    for (std::size_t s = 0; s < previous.size(); ++s) {
      if (is_listed[s] || (previous[s] >= 0 && !is_listed[index(previous[s])])) continue;
      order.push_back(s);
      is_listed[s] = true;
    }
  }
  return order;
}

/// True where a crack has no position although it came to a section farther on, as within a hole.
bool passes_without_position(const FramedPath& path, std::span<const int> previous, std::size_t s) {
  if (!std::isnan(path[s].value)) return false;
  for (std::size_t t = 0; t < previous.size(); ++t)
    for (int k = std::isnan(path[t].value) ? -1 : previous[t]; k >= 0; k = previous[index(k)])
      if (index(k) == s) return true;
  return false;
}

/// Mean of the positions at each section, had no crack stopped.
struct MeanOfAll {
  double mean = not_a_number;
  int n = 0, n_predicted = 0, n_beyond = 0;
};

/// @param left_out group that does not count
std::vector<MeanOfAll> means_of_all(std::span<const FramedPath> paths, std::span<const int> previous,
                                    Groups groups, std::optional<std::size_t> left_out, int least) {
  std::vector<std::vector<double>> value(previous.size(), std::vector<double>(paths.size(), not_a_number));
  std::vector<MeanOfAll> found(previous.size());
  for (const std::size_t s : in_order(previous)) {
    std::vector<double> before, here;
    const auto is_in = [&](std::size_t i) { return !left_out || group_of(groups, i) != *left_out; };
    const auto earlier = [&](std::size_t i) {
      return previous[s] < 0 ? not_a_number : value[index(previous[s])][i];
    };
    for (std::size_t i = 0; i < paths.size(); ++i) {
      if (!is_in(i) || std::isnan(paths[i][s].value)) continue;
      value[s][i] = paths[i][s].value;
      if (previous[s] < 0 || std::isnan(paths[i][index(previous[s])].value)) continue;
      before.push_back(earlier(i));
      here.push_back(value[s][i]);
    }
    const auto line = regression(before, here, least);
    double sum = 0, least_before = infinity, most_before = -infinity;
    for (const double one : before) {
      least_before = std::min(least_before, one);
      most_before = std::max(most_before, one);
    }
    for (std::size_t i = 0; i < paths.size(); ++i) {
      if (!is_in(i) || !paths[i][s].counts || passes_without_position(paths[i], previous, s)) continue;
      if (line && std::isnan(value[s][i]) && !std::isnan(earlier(i))) {
        value[s][i] = line->at(earlier(i));
        found[s].n_predicted += 1;
        found[s].n_beyond += !(least_before <= earlier(i) && earlier(i) <= most_before) ? 1 : 0;
      }
      if (std::isnan(value[s][i])) continue;
      sum += value[s][i];
      found[s].n += 1;
    }
    const bool is_known = previous[s] < 0 || (line && !std::isnan(found[index(previous[s])].mean));
    if (is_known && found[s].n > 0) found[s].mean = sum / found[s].n;
  }
  return found;
}

/// Half widths of the intervals of means_of_all, for each section.
std::vector<double> jackknife(std::span<const FramedPath> paths, std::span<const int> previous, Groups groups,
                              double confidence) {
  std::vector<std::vector<double>> without(previous.size());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (i > 0 && group_of(groups, i) == group_of(groups, i - 1)) continue;
    const auto means =
        means_of_all(paths, previous, groups, group_of(groups, i), least_arrivals_of_jackknife);
    for (std::size_t s = 0; s < means.size(); ++s) without[s].push_back(means[s].mean);
  }
  std::vector<double> half_widths;
  for (const auto& means : without) {
    const auto n = static_cast<double>(means.size());
    const double mean = std::accumulate(means.begin(), means.end(), 0.0) / n;
    double square = 0;
    for (const double one : means) square += std::pow(one - mean, 2);
    half_widths.push_back(n < 2
                              ? not_a_number
                              : boost::math::quantile(boost::math::students_t(n - 1), (1 + confidence) / 2) *
                                    std::sqrt(square * (n - 1) / n));
  }
  return half_widths;
}

}  // namespace

std::vector<double> band_half_widths(std::span<const FramedPath> paths, Groups groups, double confidence) {
  const std::size_t n_sections = n_sections_of(paths);
  std::vector<GroupedMoments> moments(n_sections);
  std::vector<std::vector<double>> residuals;
  for (std::size_t s = 0; s < n_sections; ++s) {
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (!std::isnan(paths[i][s].value)) moments[s].add(paths[i][s].value, group_of(groups, i));
    if (moments[s].square_error() > 0)
      residuals.push_back(relative_residuals(paths, groups, s, moments[s].mean()));
  }
  const double each = confidence_of_sections(residuals, confidence);
  std::vector<double> half_widths;
  for (const GroupedMoments& one : moments)
    half_widths.push_back(
        one.n_groups() < 2
            ? not_a_number
            : boost::math::quantile(boost::math::students_t(one.n_groups() - 1.0), (1 + each) / 2) *
                  std::sqrt(one.square_error()));
  return half_widths;
}

std::vector<int> previous_sections(const input::Sections& sections, std::span<const FramedPath> paths) {
  const std::vector<input::Section> all = sections.all();
  std::vector<int> previous(all.size(), -1);
  const auto n_arrived = [&](std::size_t s) {
    return std::ranges::count_if(paths, [&](const auto& path) { return !std::isnan(path[s].value); });
  };
  for (const auto axis : {1, 2}) {
    std::vector<std::size_t> along;
    for (std::size_t s = 0; s < all.size(); ++s)
      if (all[s].axis == axis) along.push_back(s);
    if (along.empty()) continue;
    std::ranges::sort(along, {}, [&](std::size_t s) { return all[s].position; });
    const auto first = std::ranges::max_element(along, {}, n_arrived);
    for (auto it = along.begin(); it != along.end(); ++it)
      if (it != first) previous[*it] = static_cast<int>(it < first ? *(it + 1) : *(it - 1));
  }
  return previous;
}

std::vector<Stopped> stopped_cracks(std::span<const FramedPath> paths, std::span<const int> previous,
                                    Groups groups, double confidence) {
  std::vector<Stopped> found(previous.size());
  const auto means = means_of_all(paths, previous, groups, {}, least_arrivals);
  const auto half_widths = jackknife(paths, previous, groups, confidence);
  const bool are_alone = std::ranges::adjacent_find(groups) == groups.end();
  for (std::size_t s = 0; s < previous.size(); ++s) {
    found[s].previous = previous[s];
    if (previous[s] < 0) continue;
    TwoSamples earlier;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const double before = paths[i][index(previous[s])].value;
      if (!paths[i][s].counts || std::isnan(before) || passes_without_position(paths[i], previous, s))
        continue;
      const bool arrives = !std::isnan(paths[i][s].value);
      (arrives ? earlier.first : earlier.second).push_back(before);
      (arrives ? earlier.first_group : earlier.second_group).push_back(group_of(groups, i));
    }
    found[s].n_arrived = static_cast<int>(earlier.first.size());
    found[s].n_stopped = static_cast<int>(earlier.second.size());
    const auto mean_of = [](const std::vector<double>& values) {
      return values.empty()
                 ? not_a_number
                 : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    };
    found[s].mean_arrived = mean_of(earlier.first);
    found[s].mean_stopped = mean_of(earlier.second);
    if (are_alone && found[s].n_arrived > 0 && found[s].n_stopped > 0)
      found[s].probability = permutation_probability(earlier);
    found[s].mean_of_all = means[s].mean;
    found[s].n_all = means[s].n;
    found[s].n_predicted = means[s].n_predicted;
    found[s].n_beyond = means[s].n_beyond;
    if (!std::isnan(means[s].mean)) found[s].half_width_of_all = half_widths[s];
  }
  // A line says little where more cracks lie beyond its points than it has.
  for (const std::size_t s : in_order(previous)) {
    const bool follows_none = previous[s] >= 0 && previous[index(previous[s])] >= 0 &&
                              std::isnan(found[index(previous[s])].mean_of_all);
    if (previous[s] >= 0 && (follows_none || found[s].n_beyond > found[s].n_arrived))
      found[s].mean_of_all = found[s].half_width_of_all = not_a_number;
  }
  return found;
}

PathInference path_inference(const RankStatistics& ranks, const Statistics& statistics,
                             std::span<const SampleSummary> samples, const LeaderFrame& frame,
                             const input::Sections& sections) {
  const double confidence = confidence_of_look(statistics.confidence, statistics.n_looks);
  PathInference found;
  for (std::size_t row = 0; row < ranks.start.size(); ++row) {
    std::vector<FramedPath> paths;
    std::vector<std::size_t> draws;
    for (std::size_t i = 0; i < std::min(samples.size(), index(statistics.n_needed)); ++i) {
      if (samples[i].status != SampleStatus::done) continue;
      FramedPath path;
      for (int s = 0; s < frame.n_sections(); ++s)
        path.push_back(framed_position(frame, samples[i], ranks.leading_start[row], ranks.start[row], s));
      // The leader of a body that came apart did not stop: what it missed, it passed by, as along the
      // supports.
      if (ranks.start[row] == ranks.leading_start[row] && is_separated(samples[i]))
        for (FramedPosition& position : path) position.counts &= !std::isnan(position.value);
      if (std::ranges::none_of(path, &FramedPosition::counts)) continue;
      paths.push_back(std::move(path));
      draws.push_back(i / index(statistics.replicates));
    }
    const auto append = [&](auto& all, auto own, const auto& none) {
      own.resize(index(frame.n_sections()), none);
      all.insert(all.end(), own.begin(), own.end());
    };
    append(found.band_half_width, band_half_widths(paths, draws, confidence), not_a_number);
    append(found.stopped, stopped_cracks(paths, previous_sections(sections, paths), draws, confidence),
           Stopped{});
  }
  return found;
}

std::string path_inference_text(const Statistics& statistics, std::span<const SampleSummary> samples,
                                const input::Study& study) {
  const LeaderFrame frame(study, study.sections);
  const std::vector<input::Section> sections = study.sections.all();
  const ShownUnit unit = unit_of_positions(statistics);
  const auto length = [&](double value) { return shown(value, ".3f", unit.factor); };
  TextTable bands{{"cracks", "leading", "start", "section", "mean", "+- alone", "+- band"}};
  TextTable ends{{"cracks", "leading", "start", "section", "previous section", "arrived", "mean there",
                  "stopped", "mean there", "p", "mean if all arrived", "+-", "predicted", "out of range"}};
  const auto number = [](int n) { return fmt::to_string(n); };
  const auto& starts = statistics.start_names;
  const auto add = [&](const char* name, const RankStatistics& ranks) {
    const PathInference found = path_inference(ranks, statistics, samples, frame, study.sections);
    for (std::size_t p = 0; p < ranks.reached.size(); ++p) {
      if (ranks.reached[p] == 0) continue;
      const std::size_t row = p / sections.size();
      const std::vector<std::string> which{name, starts[index(ranks.leading_start[row])],
                                           starts[index(ranks.start[row])],
                                           input::name_of(sections[p % sections.size()])};
      const auto push = [&](TextTable& table, const std::vector<std::string>& cells) {
        table.push_back(which);
        table.back().insert(table.back().end(), cells.begin(), cells.end());
      };
      // As in the table of positions: the mean of several groups is no crack's position.
      const bool is_divided = ranks.is_divided[p] != 0;
      const auto of_all = [&](double value) { return is_divided ? "-" : length(value); };
      push(bands, {is_divided ? "groups" : length(ranks.z_mean[p]), of_all(ranks.z_half_width[p]),
                   of_all(found.band_half_width[p])});
      const Stopped& stopped = found.stopped[p];
      if (stopped.previous < 0 || stopped.n_stopped + stopped.n_predicted == 0) continue;
      push(ends, {input::name_of(sections[index(stopped.previous)]), number(stopped.n_arrived),
                  length(stopped.mean_arrived), number(stopped.n_stopped), length(stopped.mean_stopped),
                  shown_probability(stopped.probability), of_all(stopped.mean_of_all),
                  of_all(stopped.half_width_of_all), number(stopped.n_predicted), number(stopped.n_beyond)});
    }
  };
  add("leader", statistics.leader);
  add("follower", statistics.follower);
  if (bands.size() == 1) return {};
  std::string text =
      fmt::format(
          "\nmean paths [{}]: +- alone holds at its section, the band at all sections of a path at once\n",
          unit.name) +
      aligned(bands, 3);
  if (ends.size() == 1) return text;
  return text +
         fmt::format(
             "\ncracks that stopped [{}]: of those that crossed the previous section, how many arrived at "
             "this "
             "one and how many stopped, each with their mean position at the previous section; p: "
             "probability "
             "of so large a difference if stopping did not depend on the position\n",
             unit.name) +
         aligned(ends, 3) +
         "mean if all arrived: with the positions of stopped cracks predicted by regression on the previous "
         "section; out of range: predicted for cracks that were outside the range of those that arrived. No "
         "mean if more were outside than arrived\n";
}

}  // namespace crackle::analysis
