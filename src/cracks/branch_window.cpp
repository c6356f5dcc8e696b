// SPDX-License-Identifier: GPL-3.0-or-later
#include "branch_window.h"

#include "cracks/branching.h"

#include "polyline.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crackle::cracks {

namespace {

/// The crack at one station: an interval across its advance without a gap.
struct Run {
  double low;
  double high;
  Indices facets;
  std::vector<std::size_t> next;  ///< overlapping runs at the next station, ascending
};

using Level = Indices;                    ///< runs of one station
using Continuation = std::vector<Level>;  ///< levels at consecutive stations

/// A crack between two planes x = const, projected on the plane of the plate.
class Window {
public:
  Window(double step, const std::vector<double>& spacing, const std::vector<std::vector<Trace>>& traces,
         double x_low, double x_high)
      : step_(step), spacing_(spacing), runs_(traces.size()) {
    std::vector<std::pair<std::pair<double, double>, std::size_t>> seen;
    for (std::size_t k = 0; k < traces.size(); ++k) {
      seen.clear();
      for (std::size_t j = k == 0 ? 0 : k - 1; j <= k + 1 && j < traces.size(); ++j) {
        for (const Trace& trace : traces[j]) {
          const double middle = (trace.x[0] + trace.x[1]) / 2;
          if (middle >= x_low && middle <= x_high)
            seen.push_back({std::minmax(trace.across[0], trace.across[1]), trace.facet});
        }
      }
      std::sort(seen.begin(), seen.end());
      for (const auto& [range, facet] : seen) {
        if (runs_[k].empty() || range.first > runs_[k].back().high + branch_gap * spacing_[k])
          runs_[k].push_back({range.first, range.second, {}, {}});
        Run& run = runs_[k].back();
        run.high = std::max(run.high, range.second);
        run.facets.push_back(facet);
      }
      for (Run& run : runs_[k]) sort_unique(run.facets);
    }
    for (std::size_t k = 0; k + 1 < runs_.size(); ++k) {
      for (Run& run : runs_[k]) {
        for (std::size_t j = 0; j < runs_[k + 1].size(); ++j) {
          if (runs_[k + 1][j].low <= run.high && run.low <= runs_[k + 1][j].high) run.next.push_back(j);
        }
      }
    }
  }

  std::vector<Detection> detections() const {
    std::vector<Detection> found;
    for (std::size_t k = 0; k + 1 < runs_.size(); ++k) {
      for (std::size_t i = 0; i < runs_[k].size(); ++i) {
        if (runs_[k][i].next.size() < 2) continue;
        const std::vector<Continuation> continuations = separate_continuations(k, runs_[k][i]);
        for (std::size_t j = 0; j + 1 < continuations.size(); ++j) {
          Detection point = follow(k + 1, continuations[j], continuations[j + 1]);
          const auto earlier = std::find_if(found.begin(), found.end(),
                                            [&](const Detection& f) { return is_extended_at(f, k, i); });
          if (earlier == found.end()) {
            found.push_back(std::move(point));
          } else {
            extend(*earlier, point);
          }
        }
      }
    }
    return found;
  }

private:
  double middle(std::size_t k, const Level& level) const {
    return (runs_[k][level.front()].low + runs_[k][level.back()].high) / 2;
  }

  Level ahead(std::size_t k, const Level& level) const {
    Level next;
    for (const std::size_t i : level)
      next.insert(next.end(), runs_[k][i].next.begin(), runs_[k][i].next.end());
    sort_unique(next);
    return next;
  }

  /// Continues from run i of station k until the continuation is min_gap_length long; empty if it ends
  /// before.
  Continuation continuation_from(std::size_t k, std::size_t i) const {
    Continuation levels{{i}};
    const double start = middle(k, levels.front());
    for (std::size_t last = k;; ++last) {
      const double length =
          std::hypot(static_cast<double>(levels.size()) * step_, middle(last, levels.back()) - start);
      if (length >= min_gap_length * spacing_[k]) return levels;
      if (last + 1 >= runs_.size()) return {};
      Level next = ahead(last, levels.back());
      if (next.empty()) return {};
      levels.push_back(std::move(next));
    }
  }

  /// The continuations of a run that are long enough and have no run in common, ordered across.
  std::vector<Continuation> separate_continuations(std::size_t k, const Run& run) const {
    std::vector<Continuation> continuations;
    for (const std::size_t j : run.next) {
      Continuation continuation = continuation_from(k + 1, j);
      if (continuation.empty()) continue;
      // Continuations are ordered across, so one that joins several earlier ones joins the last of them.
      while (!continuations.empty() &&
             (meet(continuations.back(), continuation) ||
              widest_gap(k + 1, continuations.back(), continuation) < min_branch_distance)) {
        Continuation& earlier = continuations.back();
        if (earlier.size() > continuation.size()) continuation.resize(earlier.size());
        for (std::size_t level = 0; level < earlier.size(); ++level) add(continuation[level], earlier[level]);
        continuations.pop_back();
      }
      continuations.push_back(std::move(continuation));
    }
    return continuations;
  }

  static bool meet(const Continuation& a, const Continuation& b) {
    for (std::size_t level = 0; level < std::min(a.size(), b.size()); ++level)
      if (intersects(a[level], b[level])) return true;
    return false;
  }

  /// Widest gap between two continuations, in spacings.
  double widest_gap(std::size_t k, const Continuation& lower, const Continuation& upper) const {
    double widest = 0;
    for (std::size_t level = 0; level < std::min(lower.size(), upper.size()); ++level) {
      const double gap =
          runs_[k + level][upper[level].front()].low - runs_[k + level][lower[level].back()].high;
      widest = std::max(widest, gap / spacing_[k + level]);
    }
    return widest;
  }

  /// Follows both branches from station k until they end or meet.
  Detection follow(std::size_t k, const Continuation& lower, const Continuation& upper) const {
    Detection point{};
    point.advance = advance(k);
    point.across = (runs_[k][lower.front().back()].high + runs_[k][upper.front().front()].low) / 2;
    const double first_length = min_branch_length * spacing_[k];
    std::array<Level, 2> level{lower.front(), upper.front()};
    std::size_t station = k;
    for (;;) {
      for (std::size_t side = 0; side < 2; ++side)
        collect(point.branches[side], station, level[side], first_length);
      if (station + 1 >= runs_.size()) break;
      std::array<Level, 2> next{ahead(station, level[0]), ahead(station, level[1])};
      if (next[0].empty() && next[1].empty()) break;
      ++station;
      if (intersects(next[0], next[1])) {
        std::ranges::set_intersection(next[0], next[1], std::back_inserter(point.reunited));
        break;
      }
      level = std::move(next);
    }
    point.last = station;
    measure(point, first_length);
    return point;
  }

  double advance(std::size_t station) const { return (static_cast<double>(station) + 0.5) * step_; }

  /// Adds a station's runs to a branch.
  /// @param first_length of the branch's first part
  void collect(Branch& branch, std::size_t station, const Level& level, double first_length) const {
    if (level.empty()) return;
    const double across = middle(station, level);
    branch.reach = advance(station);
    branch.line.emplace_back(branch.reach, across);
    const auto& [first_advance, first_across] = branch.line.front();
    const bool is_first = std::hypot(branch.reach - first_advance, across - first_across) <= first_length;
    for (const std::size_t i : level) {
      const Indices& facets = runs_[station][i].facets;
      branch.facets.insert(branch.facets.end(), facets.begin(), facets.end());
      if (is_first) branch.first.insert(branch.first.end(), facets.begin(), facets.end());
    }
  }

  /// The lengths of both branches, and the angle between their first parts.
  static void measure(Detection& point, double first_length) {
    std::array<double, 2> direction{};
    for (std::size_t side = 0; side < 2; ++side) {
      Branch& branch = point.branches[side];
      sort_unique(branch.facets);
      sort_unique(branch.first);
      branch.end_across = branch.line.back().second;
      branch.length = std::hypot(branch.reach - point.advance, branch.end_across - point.across);
      direction[side] = std::atan(slope(branch.line, point.advance + first_length));
    }
    point.angle = std::abs(direction[1] - direction[0]);
  }

  /// Slope of the line up to this advance, by least squares.
  static double slope(const std::vector<std::pair<double, double>>& line, double until) {
    LineFit fit;
    for (const auto& [advance, across] : line) {
      if (advance > until) break;
      fit.add(advance - line.front().first, across - line.front().second);
    }
    return fit.variance() > 0 ? fit.slope() : 0;
  }

  /// True if run i of station k, where continuations separate, closely follows the place where the branches
  /// met.
  bool is_extended_at(const Detection& point, std::size_t k, std::size_t i) const {
    const auto soon = static_cast<std::size_t>(reunion_length * spacing_[k] / step_);
    if (point.reunited.empty() || k < point.last || k > point.last + soon) return false;
    Level level = point.reunited;
    for (std::size_t station = point.last; station < k; ++station) level = ahead(station, level);
    return std::binary_search(level.begin(), level.end(), i);
  }

  double step_;
  const std::vector<double>& spacing_;  ///< local spacing at every station
  std::vector<std::vector<Run>> runs_;
};

}  // namespace

void extend(Detection& point, const Detection& later) {
  for (std::size_t side = 0; side < 2; ++side) {
    Branch& branch = point.branches[side];
    const Branch& rest = later.branches[side];
    add(branch.facets, rest.facets);
    branch.reach = rest.reach;
    branch.end_across = rest.end_across;
    branch.length =
        std::max(branch.length, std::hypot(rest.reach - point.advance, rest.end_across - point.across));
  }
  point.last = later.last;
  point.reunited = later.reunited;
}

std::vector<Detection> detect_branching(double step, const std::vector<double>& spacing,
                                        const std::vector<std::vector<Trace>>& traces, double x_low,
                                        double x_high) {
  return Window(step, spacing, traces, x_low, x_high).detections();
}

}  // namespace crackle::cracks
