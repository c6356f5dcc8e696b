// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/observation.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/cracks/crack_pattern.h"
#include "crackle/input/reader.h"
#include "sample_arms.h"

#include <fmt/format.h>
#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace crackle::experiment {

namespace {

using plane::Point;

/// Loads with a larger correlation over the samples are one quantity.
constexpr double same_load_correlation = 0.999;
/// A crack begins at the first point of its path unless the last one is this much nearer to a start.
constexpr double much_nearer = 5;
/// Places may lie outside of the body by this share of its size.
constexpr double outside_share = 0.1;

/// Distance in the y-z plane to where a crack starts: the tip of a notch with a ligament, else the nearest
/// wall.
/// @param is_under_way the crack may have come to the place along the ligament
double distance_to(const geometry::Body& body, const geometry::CrackStart& start, const Point& place,
                   bool is_under_way = false) {
  if (start.is_straight) {
    const Point tip{start.tip[1], start.tip[2]}, end{start.end[1], start.end[2]};
    return is_under_way ? project({tip, end}, place).distance : plane::norm(place - tip);
  }
  const auto& faces = body.faces();
  const auto is_wall = [&](std::size_t f) {
    const auto has = [&](const geometry::CrackStart& each) {
      return std::ranges::find(each.faces, static_cast<geometry::FaceId>(f)) != each.faces.end();
    };
    return start.is_free_surface ? std::ranges::none_of(body.crack_starts(), has) : has(start);
  };
  double nearest = infinity;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (faces[f].outward[0] != 0 || !is_wall(f)) continue;
    const geometry::Patch& patch = faces[f].patch;
    const geometry::Point from = patch.at(patch.domain.lower), to = patch.at(patch.domain.upper);
    nearest = std::min(nearest, project({{from[1], from[2]}, {to[1], to[2]}}, place).distance);
  }
  return nearest;
}

/// Seeds of errors.
RandomStream errors(const ObservedSamples& samples, const ObservedSample& sample, Quantity quantity,
                    std::uint64_t stream) {
  return RandomStream(samples.seed, sample.number, "match: errors")
      .substream(stream)
      .substream(index(quantity));
}

/// The root mean square over the experiments of an observable.
double common_error(std::span<const Experiment> experiments, const std::vector<std::size_t>& numbers,
                    double Experiment::*error) {
  double sum = 0;
  for (const std::size_t i : numbers) sum += std::pow(experiments[i].*error, 2);
  return std::sqrt(sum / static_cast<double>(numbers.size()));
}

std::optional<Observable> observe_load(std::span<const Experiment> experiments,
                                       const ObservedSamples& samples, Quantity quantity,
                                       std::uint64_t stream) {
  Observable found{.quantity = quantity, .unit = "N"};
  found.of_experiments.n_columns = found.of_samples.n_columns = found.with_error.n_columns = 1;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    const auto& load = quantity == Quantity::peak_load ? experiments[i].peak_load : experiments[i].onset_load;
    if (!load) continue;
    found.experiments.push_back(i);
    found.of_experiments.add(std::array{*load});
  }
  if (found.experiments.empty()) return std::nullopt;
  found.error = common_error(experiments, found.experiments, &Experiment::load_error);
  for (std::size_t i = 0; i < samples.samples.size(); ++i) {
    const ObservedSample& sample = samples.samples[i];
    const double load = load_of(sample.summary, quantity);
    if (std::isnan(load)) continue;
    RandomStream random = errors(samples, sample, quantity, stream);
    found.samples.push_back(i);
    found.of_samples.add(std::array{load});
    found.with_error.add(std::array{load + (found.error > 0 ? found.error * random.normal() : 0)});
  }
  return found;
}

/// The box that holds the path and the tips.
plane::Bounds bounds_of(const Experiment& experiment) {
  Polyline points = experiment.lines.empty() ? Polyline{} : experiment.lines.front();
  for (const Tip& tip : experiment.tips) points.push_back(tip.at);
  return plane::bounds_of(points);
}

/// The paths of experiments that are compared.
struct SeenPaths {
  int start = -1;  ///< of the first experiment's crack
  std::vector<std::size_t> experiments;
  std::vector<Polyline> lines;
  std::vector<Window> windows;
  double error_length = 0;
};

SeenPaths paths_of(std::span<const Experiment> experiments, const ObservedSamples& samples,
                   const geometry::Body& body) {
  SeenPaths seen;
  for (std::size_t i = 0; i < experiments.size(); ++i) {
    const Experiment& experiment = experiments[i];
    if (experiment.lines.empty()) continue;
    Polyline line = experiment.lines.front();
    const int start = crack_start_of(body, experiment);
    if (seen.lines.empty()) seen.start = start;
    if (start != seen.start) {
      const geometry::Symmetry* const symmetry = symmetry_to(samples.symmetries, start, seen.start);
      if (symmetry == nullptr) continue;
      for (Point& p : line) p = image_of(*symmetry, p);
    }
    seen.experiments.push_back(i);
    seen.windows.push_back({line.front(), line.back(), experiment.is_arrested});
    seen.lines.push_back(std::move(line));
    seen.error_length += experiment.path_error_length;
  }
  seen.error_length /= static_cast<double>(std::max<std::size_t>(1, seen.lines.size()));
  return seen;
}

std::optional<Observable> observe_path(std::span<const Experiment> experiments,
                                       const ObservedSamples& samples, const geometry::Body& body,
                                       std::uint64_t stream) {
  Observable found{.quantity = Quantity::path, .unit = "m"};
  const SeenPaths seen = paths_of(experiments, samples, body);
  if (seen.lines.empty()) return std::nullopt;
  found.experiments = seen.experiments;
  found.error = common_error(experiments, found.experiments, &Experiment::path_error);
  found.error_length = seen.error_length;
  Polyline all_points;
  for (const Polyline& line : seen.lines) all_points.insert(all_points.end(), line.begin(), line.end());
  const plane::Bounds box = plane::bounds_of(all_points);
  std::vector<const TimedLine*> arms;
  double margin = 0, n_arms = 0;  // all curves are drawn out alike
  for (std::size_t i = 0; i < samples.samples.size(); ++i) {
    found.samples.push_back(i);
    arms.push_back(arm_in_sight(samples.samples[i], seen.start, box));
    if (arms.back() == nullptr) continue;
    if (arms.back()->is_turned) found.turned.push_back(i);
    margin += drawn_out_by(*arms.back());
    n_arms += 1;
  }
  margin /= std::max(1.0, n_arms);
  std::vector<Polyline> curves, exact(arms.size()), read(arms.size());  // empty without a crack
  for (const Polyline& line : seen.lines) curves.push_back(extended(line, margin));
  for (std::size_t i = 0; i < arms.size(); ++i) {
    if (arms[i] == nullptr) continue;
    exact[i] = extended(arms[i]->points, margin);
    read[i] = with_reading_error(exact[i], found.error, seen.error_length,
                                 errors(samples, samples.samples[i], Quantity::path, stream));
    curves.push_back(read[i]);
  }
  found.frame = path_frame(curves, seen.windows);
  if (!found.frame) return std::nullopt;
  for (ValueTable* const table : {&found.of_experiments, &found.of_samples, &found.with_error})
    table->n_columns = n_stations;
  for (std::size_t k = 0; k < seen.lines.size(); ++k)
    found.of_experiments.add(offsets(*found.frame, curves[k]));
  for (const Polyline& curve : exact) found.of_samples.add(offsets(*found.frame, curve));
  for (const Polyline& curve : read) found.with_error.add(offsets(*found.frame, curve));
  return found;
}

std::optional<Observable> observe_tips(const Experiment& experiment, const ObservedSamples& samples,
                                       const geometry::Body& body, std::uint64_t stream) {
  if (experiment.tips.empty()) return std::nullopt;
  Observable found{.quantity = Quantity::tip_times, .unit = "s", .error = experiment.time_error};
  for (ValueTable* const table : {&found.of_experiments, &found.of_samples, &found.with_error})
    table->n_columns = experiment.tips.size();
  found.experiments = {0};
  std::vector<double> times;
  for (const Tip& tip : experiment.tips) times.push_back(tip.time);
  found.of_experiments.add(times);
  const int start = crack_start_of(body, experiment);
  for (std::size_t i = 0; i < samples.samples.size(); ++i) {
    const ObservedSample& sample = samples.samples[i];
    const TimedLine* const arm = arm_in_sight(sample, start, bounds_of(experiment));
    RandomStream random = errors(samples, sample, Quantity::tip_times, stream);
    found.samples.push_back(i);
    for (std::size_t k = 0; k < times.size(); ++k)
      times[k] = arm == nullptr ? not_a_number : arrival_at(*arm, experiment.tips[k].at);
    found.of_samples.add(times);
    for (double& time : times) time += found.error > 0 ? found.error * random.normal() : 0;
    found.with_error.add(times);
  }
  return found;
}

}  // namespace

ObservedSamples sort_samples(std::span<const analysis::SampleSummary> rows, std::uint64_t seed) {
  ObservedSamples sorted{.n_planned = rows.size(), .seed = seed};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const analysis::SampleSummary& row = rows[i];
    if (row.status == analysis::SampleStatus::pending)
      sorted.missing.push_back(i);
    else if (row.status == analysis::SampleStatus::failed)
      sorted.failed.push_back(i);
    else if (analysis::is_undecided(row))
      sorted.undecided.push_back(i);
    else
      sorted.samples.push_back({.number = i, .summary = row});
  }
  return sorted;
}

bool needs_arms(std::span<const Experiment> experiments) {
  return std::ranges::any_of(
      experiments, [](const Experiment& each) { return !each.lines.empty() || !each.tips.empty(); });
}

int crack_start_of(const geometry::Body& body, const Experiment& experiment) {
  const auto& starts = body.crack_starts();
  // The free surface counts last: where a path ends, every crack meets it.
  const auto nearest_to = [&](const Point& place, bool is_under_way = false) {
    std::pair<int, double> nearest{-1, infinity};
    for (int s = 0; s < std::ssize(starts); ++s) {
      if (starts[index(s)].is_free_surface) continue;
      const double distance = distance_to(body, starts[index(s)], place, is_under_way);
      if (distance < nearest.second) nearest = {s, distance};
    }
    return nearest;
  };
  const auto free_surface = std::ranges::find_if(starts, &geometry::CrackStart::is_free_surface);
  const int otherwise =
      free_surface == starts.end() ? -1 : static_cast<int>(std::distance(starts.begin(), free_surface));
  if (experiment.lines.empty()) {
    if (experiment.tips.empty()) return -1;
    const int found = nearest_to(experiment.tips.front().at, true).first;
    return found >= 0 ? found : otherwise;
  }
  const Point& front = experiment.lines.front().front();
  const Point& back = experiment.lines.front().back();
  const auto first = nearest_to(front);
  const auto last = nearest_to(back);
  const bool begins_at_front = first.second <= much_nearer * last.second;
  const auto& [start, distance] = begins_at_front ? first : last;
  if (otherwise < 0) return start;
  return distance <= distance_to(body, *free_surface, begins_at_front ? front : back) ? start : otherwise;
}

void check_places(const std::filesystem::path& file, std::span<const Experiment> experiments,
                  const geometry::Body& body) {
  const auto& [lower, upper] = body.bounds();
  std::vector<std::string> messages;
  for (const Experiment& experiment : experiments) {
    if (experiment.lines.empty() && experiment.tips.empty()) continue;
    const plane::Bounds seen = bounds_of(experiment);
    bool is_inside = true;
    for (const std::size_t i : {0u, 1u}) {
      const double margin = outside_share * (upper[i + 1] - lower[i + 1]);
      is_inside =
          is_inside && seen.lower[i] >= lower[i + 1] - margin && seen.upper[i] <= upper[i + 1] + margin;
    }
    if (is_inside) continue;
    messages.push_back(fmt::format(
        "{}: experiment \"{}\": its crack goes from y = {:.4g} to {:.4g} mm and from z = {:.4g} to {:.4g} "
        "mm, the body from y = {:.4g} to {:.4g} mm and from z = {:.4g} to {:.4g} mm; set origin, angle and "
        "mirror, or the units in the header of the file",
        file.string(), experiment.name, 1e3 * seen.lower[0], 1e3 * seen.upper[0], 1e3 * seen.lower[1],
        1e3 * seen.upper[1], 1e3 * lower[1], 1e3 * upper[1], 1e3 * lower[2], 1e3 * upper[2]));
  }
  if (!messages.empty()) throw input::InputError(messages);
}

const char* name_of(Quantity quantity) {
  constexpr std::array names{"path", "onset_load", "peak_load", "tip_times"};
  return names[index(quantity)];
}

double load_of(const analysis::SampleSummary& row, Quantity quantity) {
  if (quantity == Quantity::peak_load) return row.peak_load;
  return std::isnan(row.onset_force) ? row.first_break_load : row.onset_force;
}

bool is_same_load(const Observable& one, const Observable& other) {
  if (one.unit != "N" || other.unit != "N" || one.samples != other.samples) return false;
  const auto n = static_cast<Eigen::Index>(one.of_samples.n_rows());
  const auto centred = [n](const Observable& each) {
    const Eigen::Map<const Eigen::ArrayXd> load(each.of_samples.values.data(), n);
    return Eigen::ArrayXd(load - load.mean());
  };
  const Eigen::ArrayXd a = centred(one), b = centred(other);
  return n > 2 && (a * b).sum() > same_load_correlation * std::sqrt(a.square().sum() * b.square().sum());
}

std::vector<Observable> observe(std::span<const Experiment> experiments, const ObservedSamples& samples,
                                const geometry::Body& body, std::uint64_t stream) {
  std::vector<Observable> all;
  const auto add = [&](std::optional<Observable> found) {
    if (found) all.push_back(std::move(*found));
  };
  add(observe_path(experiments, samples, body, stream));
  for (const Quantity load : {Quantity::onset_load, Quantity::peak_load})
    add(observe_load(experiments, samples, load, stream));
  if (experiments.size() == 1) add(observe_tips(experiments.front(), samples, body, stream));
  return all;
}

}  // namespace crackle::experiment
