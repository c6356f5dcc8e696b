// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/running_statistics.h"

#include "analysis/censored_values.h"
#include "analysis/grouped_values.h"
#include "analysis/path_groups.h"
#include "analysis/result_list.h"
#include "analysis/stop_rule.h"
#include "common/failure.h"
#include "common/index.h"
#include "common/real.h"
#include "cracks/crack_pattern.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

namespace crackle::analysis {

namespace {

/// Adds a * b exactly: the rounding error of the product is the remainder of a fused multiply-add.
void add_product(parallel::ExactSum& sum, double a, double b) {
  const double product = a * b;
  sum.add(product);
  sum.add(std::fma(a, b, -product));
}

/// Rounding error of a rounded sum.
double remainder(parallel::ExactSum sum, double rounded) {
  sum.add(-rounded);
  return sum.value();
}

void check_row(const SampleSummary& row, std::size_t sample, const Statistics& shape) {
  const auto n_positions = static_cast<std::size_t>(shape.n_starts * shape.n_sections);
  if (row.position.size() != n_positions || row.z_spread.size() != n_positions) {
    fail<std::invalid_argument>("sample {}: {} crack positions instead of {}", sample, row.position.size(),
                                n_positions);
  }
  if (row.pattern < -1 || row.pattern >= n_patterns) {
    fail<std::invalid_argument>("sample {}: pattern {} is not one of 0 to {}", sample, row.pattern,
                                n_patterns - 1);
  }
  if (row.leading_start < -1 || row.leading_start >= shape.n_starts) {
    fail<std::invalid_argument>("sample {}: leading start {} of {}", sample, row.leading_start,
                                shape.n_starts);
  }
}

/// Empty rows for the leading or the following cracks.
RankStatistics empty_ranks(const LeaderFrame& frame, bool leaders) {
  RankStatistics ranks;
  const std::vector<std::int32_t>& reference = frame.reference();
  for (std::int32_t leading = 0; leading < frame.n_starts(); ++leading) {
    if (reference[static_cast<std::size_t>(leading)] != leading) continue;
    for (std::int32_t start = 0; start < frame.n_starts(); ++start) {
      if ((start == leading) != leaders) continue;
      ranks.leading_start.push_back(leading);
      ranks.start.push_back(start);
    }
  }
  return ranks;
}

Statistics empty_statistics(std::size_t n_samples, const LeaderFrame& frame, double confidence) {
  if (!(confidence > 0 && confidence < 1))
    fail<std::invalid_argument>("confidence {}: must lie between 0 and 1", confidence);
  Statistics statistics;
  statistics.n_starts = frame.n_starts();
  statistics.n_sections = frame.n_sections();
  statistics.n_samples = static_cast<int>(n_samples);
  statistics.n_needed = statistics.n_samples;
  statistics.confidence = confidence;
  statistics.reference_start = frame.reference();
  statistics.start_names = frame.start_names();
  statistics.leader = statistics.leader_one_crack = statistics.leader_two_cracks = empty_ranks(frame, true);
  statistics.follower = empty_ranks(frame, false);
  return statistics;
}

FramedPosition position_in(const LeaderFrame& frame, const RankStatistics& ranks, const SampleSummary& row,
                           std::size_t p) {
  const std::size_t rank = p / index(frame.n_sections());
  return framed_position(frame, row, ranks.leading_start[rank], ranks.start[rank],
                         static_cast<int>(p % index(frame.n_sections())));
}

/// Which running statistics over samples 0 to i are computed; `all` takes ten times as long as `none`.
enum class Running { none, means, all };

/// Computes statistics of the FramedPosition position_at(row, index) over the completed rows.
template <class PositionAt>
void compute_paths(PathStatistics& paths, std::size_t n_positions, const Statistics& shape,
                   std::span<const SampleSummary> rows, Running running_values, PositionAt&& position_at) {
  const auto n_samples = static_cast<std::size_t>(shape.n_samples);
  paths.running_mean.assign(n_samples * n_positions, not_a_number);
  paths.running_half_width.assign(n_samples * n_positions, not_a_number);
  for (auto* values : {&paths.spread_mean, &paths.z_mean, &paths.z_std, &paths.z_half_width})
    values->assign(n_positions, not_a_number);
  paths.reached.assign(n_positions, 0);
  paths.z_quantile.clear();
  const double confidence = confidence_of_look(shape.confidence, shape.n_looks);
  std::vector<double> quantiles(2, not_a_number);  // Student's, by the number of values
  const auto half_width = [&](const Moments& moments, const GroupedMoments& by_draws) {
    const int n_independent = shape.replicates > 1 ? by_draws.n_groups() : moments.count();
    const auto n = static_cast<std::size_t>(n_independent);
    if (quantiles.size() <= n) quantiles.resize(n + 1, not_a_number);
    if (std::isnan(quantiles[n])) quantiles[n] = student_quantile(n_independent, confidence);
    if (shape.replicates > 1) return quantiles[n] * std::sqrt(by_draws.square_error());
    return quantiles[n] * moments.standard_deviation() / std::sqrt(moments.count());
  };
  for (std::size_t p = 0; p < n_positions; ++p) {
    Moments moments, spreads;
    GroupedMoments by_draws;
    std::vector<double> values;
    double running_mean = not_a_number, running_half_width = not_a_number;
    // Samples that are not needed repeat the last values.
    for (std::size_t i = 0; i < (running_values != Running::none && !rows.empty() ? n_samples : rows.size());
         ++i) {
      const bool is_done = i < rows.size() && rows[i].status == SampleStatus::done;
      const FramedPosition found = is_done ? position_at(rows[i], p) : FramedPosition{};
      if (!std::isnan(found.value)) {
        moments.add(found.value);
        by_draws.add(found.value, i / index(shape.replicates));
        values.push_back(found.value);
        if (!std::isnan(found.spread)) spreads.add(found.spread);
      }
      if (running_values == Running::none) continue;
      if (!std::isnan(found.value)) {
        running_mean = moments.mean();
        if (running_values == Running::all) running_half_width = half_width(moments, by_draws);
      }
      paths.running_mean[i * n_positions + p] = running_mean;
      paths.running_half_width[i * n_positions + p] = running_half_width;
    }
    for (const double share : quantile_shares) paths.z_quantile.push_back(quantile(values, share));
    paths.reached[p] = moments.count();
    paths.z_mean[p] = moments.mean();
    paths.z_std[p] = moments.standard_deviation();
    if (moments.count() > 1) paths.z_half_width[p] = half_width(moments, by_draws);
    paths.spread_mean[p] = spreads.mean();
  }
}

/// The groups of each row's samples.
/// @param pattern as in compute_ranks
void compute_groups(RankStatistics& ranks, const LeaderFrame& frame, std::optional<cracks::Pattern> pattern,
                    const Statistics& shape, std::span<const SampleSummary> rows) {
  const std::size_t n_sections = index(frame.n_sections());
  ranks.groups.clear();
  ranks.is_divided.assign(ranks.start.size() * n_sections, 0);
  for (std::size_t rank = 0; rank < ranks.start.size() && n_sections > 0; ++rank) {
    const auto position = [&](const SampleSummary& row, std::size_t section) {
      const bool counts = row.status == SampleStatus::done &&
                          (!pattern || row.pattern == static_cast<std::int32_t>(*pattern));
      return counts ? position_in(frame, ranks, row, rank * n_sections + section) : FramedPosition{};
    };
    std::vector<std::vector<double>> paths(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t s = 0; s < n_sections; ++s) paths[i].push_back(position(rows[i], s).value);
    const std::vector<int> group_of_sample = path_groups(paths);
    const int n_groups = rows.empty() ? 0 : 1 + std::ranges::max(group_of_sample);
    for (int k = 0; k < n_groups && n_groups > 1; ++k) {
      PathGroup& group = ranks.groups.emplace_back();
      group.row = rank;
      compute_paths(group, n_sections, shape, rows, Running::none,
                    [&](const SampleSummary& row, std::size_t section) {
                      const bool is_in = group_of_sample[index(&row - rows.data())] == k;
                      return is_in ? position(row, section) : FramedPosition{};
                    });
      std::vector<double> hits;
      std::vector<std::size_t> draws;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (std::ranges::all_of(paths[i], [](double value) { return std::isnan(value); })) continue;
        hits.push_back(group_of_sample[i] == k ? 1 : 0);
        draws.push_back(i / index(shape.replicates));
      }
      group.n = static_cast<int>(std::ranges::count(hits, 1.0));
      group.n_of = static_cast<int>(hits.size());
      group.share = static_cast<double>(group.n) / group.n_of;
      const Interval interval = share_interval(hits, draws, shape.confidence);
      group.share_lower = interval.lower;
      group.share_upper = interval.upper;
    }
    std::ranges::copy(divided_sections(paths, group_of_sample),
                      ranks.is_divided.begin() + static_cast<std::ptrdiff_t>(rank * n_sections));
  }
}

/// Marks where cracks of a start that lead or follow are in groups.
void mark_divided(Statistics& statistics, const LeaderFrame& frame, std::span<const SampleSummary> rows) {
  statistics.is_divided.assign(index(frame.n_starts() * frame.n_sections()), 0);
  std::vector<std::uint8_t> leads(index(frame.n_starts()), 0);
  for (const SampleSummary& row : rows)
    if (row.status == SampleStatus::done && row.leading_start >= 0) leads[index(row.leading_start)] = 1;
  for (const RankStatistics* ranks : {&statistics.leader, &statistics.follower})
    for (std::size_t p = 0; p < ranks->is_divided.size(); ++p) {
      const std::size_t rank = p / index(frame.n_sections());
      const int section = static_cast<int>(p % index(frame.n_sections()));
      for (int leading = 0; leading < frame.n_starts() && ranks->is_divided[p] != 0; ++leading) {
        if (leads[index(leading)] == 0 || frame.reference()[index(leading)] != ranks->leading_start[rank])
          continue;
        if (const auto source = frame.source(leading, ranks->start[rank], section))
          statistics.is_divided[index(source->start * frame.n_sections() + source->section)] = 1;
      }
    }
}

/// @param pattern of the samples that count; all if empty
void compute_ranks(RankStatistics& ranks, const LeaderFrame& frame, std::optional<cracks::Pattern> pattern,
                   const Statistics& shape, std::span<const SampleSummary> rows, Running running_values) {
  const std::size_t n_positions = ranks.start.size() * static_cast<std::size_t>(frame.n_sections());
  ranks.counted.assign(n_positions, 0);
  compute_paths(ranks, n_positions, shape, rows, running_values,
                [&](const SampleSummary& row, std::size_t p) {
                  if (pattern && row.pattern != static_cast<std::int32_t>(*pattern)) return FramedPosition{};
                  const FramedPosition found = position_in(frame, ranks, row, p);
                  if (found.counts) ++ranks.counted[p];
                  return found;
                });
  compute_groups(ranks, frame, pattern, shape, rows);
}

void compute_shares(Statistics& statistics, std::span<const SampleSummary> rows) {
  std::vector<std::size_t> draws;
  std::array<std::vector<double>, n_patterns> hits;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].status != SampleStatus::done) continue;
    draws.push_back(i / index(statistics.replicates));
    for (std::size_t k = 0; k < hits.size(); ++k) hits[k].push_back(index(rows[i].pattern) == k ? 1 : 0);
  }
  const auto n = static_cast<double>(draws.size());
  statistics.n_done = static_cast<int>(draws.size());
  for (auto* values : {&statistics.pattern_share, &statistics.pattern_half_width, &statistics.pattern_lower,
                       &statistics.pattern_upper})
    values->fill(not_a_number);
  if (draws.empty()) return;
  for (std::size_t k = 0; k < hits.size(); ++k) {
    const double share = static_cast<double>(std::ranges::count(hits[k], 1.0)) / n;
    const Interval interval = share_interval(hits[k], draws, statistics.confidence);
    const auto n_independent = static_cast<int>(independent_values(hits[k], draws));
    statistics.pattern_share[k] = share;
    statistics.pattern_half_width[k] =
        wilson_interval(share, n_independent, statistics.confidence).half_width;
    statistics.pattern_lower[k] = interval.lower;
    statistics.pattern_upper[k] = interval.upper;
  }
}

void compute_traces(Statistics& statistics, std::span<const SampleSummary> rows) {
  const std::size_t n = statistics.n_planes * cracks::n_trace_rows(index(statistics.n_starts));
  statistics.traces.assign(n, {});
  for (std::size_t p = 0; p < n; ++p) {
    TraceStatistics& found = statistics.traces[p];
    std::vector<double> hits;
    std::vector<std::size_t> draws, draws_of_hits;
    std::vector<const cracks::StartTrace*> crossing;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].status != SampleStatus::done || rows[i].traces.size() != n) continue;
      const cracks::StartTrace& trace = rows[i].traces[p];
      hits.push_back(trace.length > 0 ? 1 : 0);
      draws.push_back(i / index(statistics.replicates));
      if (!(trace.length > 0)) continue;
      crossing.push_back(&trace);
      draws_of_hits.push_back(draws.back());
    }
    found.n_of = static_cast<int>(hits.size());
    found.n_crossed = static_cast<int>(crossing.size());
    for_each_trace_result([&](const ResultInfo&, auto member) {
      std::vector<double> values;
      for (const cracks::StartTrace* const trace : crossing) values.push_back(trace->*member);
      found.results.push_back(mean_estimate(values, draws_of_hits, statistics.confidence));
    });
    if (hits.empty()) continue;
    found.share = static_cast<double>(found.n_crossed) / found.n_of;
    found.interval = share_interval(hits, draws, statistics.confidence);
  }
}

void compute_fragments(Statistics& statistics, std::span<const SampleSummary> rows) {
  FragmentStatistics& found = statistics.fragments = {};
  std::vector<std::size_t> draws;
  std::vector<const FragmentSummary*> known;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].status != SampleStatus::done || rows[i].fragments.heavier.empty()) continue;
    known.push_back(&rows[i].fragments);
    found.n_fragmented += is_fragmented(rows[i]) ? 1 : 0;
    draws.push_back(i / index(statistics.replicates));
  }
  found.n_of = static_cast<int>(known.size());
  const auto add = [&](std::vector<MeanEstimate>& estimates, const auto& value_of) {
    std::vector<double> values;
    std::vector<std::size_t> draws_of_values;
    for (std::size_t i = 0; i < known.size(); ++i) {
      const double value = value_of(*known[i]);
      if (std::isnan(value)) continue;  // without fragments there is no mean mass
      values.push_back(value);
      draws_of_values.push_back(draws[i]);
    }
    estimates.push_back(mean_estimate(values, draws_of_values, statistics.confidence));
  };
  for_each_fragment_result([&](const ResultInfo&, auto member) {
    add(found.results, [member](const FragmentSummary& row) { return row.*member; });
  });
  if (known.empty()) return;
  for (std::size_t k = 0; k < known.front()->heavier.size(); ++k)
    add(found.heavier, [k](const FragmentSummary& row) { return row.heavier.at(k); });
}

/// The statistics of the first rows, which form the whole ensemble; `shape` gives shape and confidence.
Statistics compute(const Statistics& shape, const LeaderFrame& frame, std::span<const SampleSummary> rows,
                   Running running_values) {
  Statistics statistics = shape;
  compute_paths(statistics, static_cast<std::size_t>(shape.n_starts * shape.n_sections), shape, rows,
                running_values, [](const SampleSummary& row, std::size_t p) {
                  return FramedPosition{true, row.position[p], row.z_spread[p]};
                });
  compute_ranks(statistics.leader, frame, std::nullopt, shape, rows, running_values);
  compute_ranks(statistics.leader_one_crack, frame, cracks::Pattern::one_crack, shape, rows, running_values);
  compute_ranks(statistics.leader_two_cracks, frame, cracks::Pattern::two_cracks, shape, rows,
                running_values);
  compute_ranks(statistics.follower, frame, std::nullopt, shape, rows, running_values);
  mark_divided(statistics, frame, rows);
  compute_shares(statistics, rows);
  compute_traces(statistics, rows);
  compute_fragments(statistics, rows);
  return statistics;
}

}  // namespace

WilsonInterval wilson_interval(double share, double n, double confidence) {
  const double z = boost::math::quantile(boost::math::normal(), (1 + confidence) / 2);
  const double scale = 1 + z * z / n;
  return {(share + z * z / (2.0 * n)) / scale,
          z * std::sqrt(share * (1 - share) / n + z * z / (4.0 * n * n)) / scale};
}

Interval share_interval(int n_hits, int n, double confidence) {
  const WilsonInterval interval = wilson_interval(static_cast<double>(n_hits) / n, n, confidence);
  // The ends are exactly 0 and 1 if none or all are hits.
  return {n_hits == 0 ? 0 : std::max(0.0, interval.centre - interval.half_width),
          n_hits == n ? 1 : std::min(1.0, interval.centre + interval.half_width)};
}

double student_quantile(int n, double confidence) {
  if (n < 2) return not_a_number;
  return boost::math::quantile(boost::math::students_t(n - 1), (1 + confidence) / 2);
}

double student_half_width(double standard_deviation, int n, double confidence) {
  return student_quantile(n, confidence) * standard_deviation / std::sqrt(n);
}

void Moments::add(double value) {
  first_.add(value);
  add_product(second_, value, value);
  ++n_;
}

double Moments::mean() const {
  return n_ > 0 ? first_.value() / n_ : not_a_number;
}

double Moments::standard_deviation() const {
  if (n_ < 2) return not_a_number;
  // n (sum of squares) - (sum)^2 without cancellation: every sum is represented by its rounded value and a
  // remainder.
  const double first = first_.value();
  const double second = second_.value();
  parallel::ExactSum difference;
  add_product(difference, n_, second);
  add_product(difference, n_, remainder(second_, second));
  add_product(difference, -first, first);
  add_product(difference, -2 * first, remainder(first_, first));
  return std::sqrt(std::max(0.0, difference.value()) / n_ / (n_ - 1));
}

RunningStatistics::RunningStatistics(std::size_t n_samples, LeaderFrame frame, double confidence)
    : frame_(std::move(frame)),
      statistics_(empty_statistics(n_samples, frame_, confidence)),
      rows_(n_samples, empty_summary(frame_.n_starts(), frame_.n_sections(), SampleStatus::pending)),
      leader_moments_(statistics_.leader.start.size() * static_cast<std::size_t>(frame_.n_sections())) {}

RunningStatistics::RunningStatistics(std::size_t n_samples, int n_starts, int n_sections, double confidence)
    : RunningStatistics(n_samples, LeaderFrame(n_starts, n_sections), confidence) {}

RunningStatistics::RunningStatistics(const input::Study& study)
    : RunningStatistics(static_cast<std::size_t>(study.ensemble.samples), LeaderFrame(study, study.sections),
                        study.ensemble.stop ? study.ensemble.stop->confidence : default_confidence) {
  statistics_.base = study.mesh.base;
  statistics_.replicates = study.ensemble.replicates;
  statistics_.n_planes = study.sections.planes.size();
  statistics_.crack_parts = crack_parts(study.materials, study.interfaces);
  statistics_.has_strength_scatter =
      study.fracture.variation.has_value() || !study.random.empty() || statistics_.n_starts == 0;
  stop_ = study.ensemble.stop;
  if (!stop_) return;
  looks_ = look_schedule(study.ensemble.samples, stop_->min_samples);
  statistics_.n_looks = static_cast<int>(looks_.size());
}

void RunningStatistics::add(std::size_t sample, SampleSummary row) {
  if (sample >= rows_.size())
    fail<std::invalid_argument>("sample {}: the ensemble has {}", sample, rows_.size());
  if (row.status == SampleStatus::pending) return;
  if (rows_[sample].status != SampleStatus::pending)
    fail<std::invalid_argument>("sample {} is in the statistics already", sample);
  if (row.status == SampleStatus::done) {
    check_row(row, sample, statistics_);
    for (std::size_t p = 0; p < leader_moments_.size(); ++p) {
      const double position = position_in(frame_, statistics_.leader, row, p).value;
      if (!std::isnan(position)) leader_moments_[p].add(position);
    }
    ++statistics_.n_done;
  }
  rows_[sample] = std::move(row);
  while (n_ended_ < rows_.size() && rows_[n_ended_].status != SampleStatus::pending) ++n_ended_;
  look();
}

void RunningStatistics::look() {
  if (!stop_ || stopped_at_) return;
  // At the last look all samples are done: nothing is left to stop.
  for (; next_look_ + 1 < looks_.size() && looks_[next_look_] <= n_ended_; ++next_look_) {
    const std::size_t n = looks_[next_look_];
    const auto rows = std::span(rows_).first(n);
    Statistics found = statistics_;  // input of the rule
    compute_ranks(found.leader, frame_, std::nullopt, found, rows, Running::none);
    compute_shares(found, rows);
    if (is_known(found, stop_->half_width)) {
      stopped_at_ = n;
      return;
    }
  }
}

RunningStatistics::LeaderPosition RunningStatistics::leader_position(int section) const {
  LeaderPosition most;
  const Statistics end = stopped_at_ ? statistics() : Statistics{};
  for (std::size_t p = static_cast<std::size_t>(section);
       section < statistics_.n_sections && p < leader_moments_.size();
       p += static_cast<std::size_t>(statistics_.n_sections)) {
    const LeaderPosition here =
        stopped_at_ ? LeaderPosition{end.leader.z_mean[p], end.leader.reached[p], p}
                    : LeaderPosition{leader_moments_[p].mean(), leader_moments_[p].count(), p};
    if (here.n > most.n) most = here;
  }
  return most;
}

bool RunningStatistics::is_divided(const LeaderPosition& leaders) const {
  if (leaders.n == 0) return false;
  RankStatistics ranks = statistics_.leader;
  compute_groups(ranks, frame_, std::nullopt, statistics_, needed_rows());
  return ranks.is_divided[leaders.position] != 0;
}

RunningStatistics::MedianLoad RunningStatistics::median_load() const {
  const auto rows = needed_rows();
  MedianLoad found{.name = headline_load(rows), .median = {}};
  found.n_unbroken = static_cast<int>(std::ranges::count_if(rows, is_unbroken));
  for_each_result([&](const ResultInfo& info, auto member) {
    if (found.name == info.name) found.median = censored_quantile(observations(info, member, rows, 1), 0.5);
  });
  return found;
}

void RunningStatistics::stop_at(std::size_t n) {
  if (n > rows_.size())
    fail<std::invalid_argument>("stop at sample {}: the ensemble has {}", n, rows_.size());
  stopped_at_ = n;
}

Statistics RunningStatistics::statistics() const {
  Statistics shape = statistics_;
  if (stopped_at_) shape.n_needed = static_cast<int>(*stopped_at_);
  return compute(shape, frame_, needed_rows(), Running::means);
}

Statistics with_running_half_widths(const Statistics& statistics, std::span<const SampleSummary> samples,
                                    const LeaderFrame& frame) {
  return compute(statistics, frame, samples.first(static_cast<std::size_t>(statistics.n_needed)),
                 Running::all);
}

}  // namespace crackle::analysis
