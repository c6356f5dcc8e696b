// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/branching.h"

#include "common/disjoint_sets.h"
#include "common/index.h"
#include "common/median.h"

#include "crack_graph.h"
#include "polyline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

namespace crackle::cracks {

namespace {

constexpr double stations_per_spacing = 4;
/// The window of the whole thickness.
constexpr int projection = -1;
/// Minimum overlap of branching points detected in two windows to be identified; such windows have at most
/// half of their facets in common.
constexpr double min_overlap_of_windows = 0.1;

/// One of two branches as one window shows it.
struct Branch {
  Indices facets;
  Indices first;                                ///< the subset on the first min_branch_length
  std::vector<std::pair<double, double>> line;  ///< advance, across: centre at every station
  double reach = 0;                             ///< advance of its end [m]
  double end_across = 0;                        ///< coordinate across at its end [m]
  double length = 0;                            ///< straight length from the branching point to its end [m]
};

/// A branching point detected in one window; branches 0 and 1 are at lower and higher values across.
struct Detection {
  double advance;  ///< where the branches separate
  double across;
  double angle;
  std::array<Branch, 2> branches;
  int window = 0;        ///< window of the detection
  std::size_t last = 0;  ///< station of the last levels
  Indices reunited;      ///< the pieces there, if the branches have met again
};

/// Extends branches that have met with those of a later detection.
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

using Level = Indices;                    ///< pieces of one station
using Continuation = std::vector<Level>;  ///< levels at consecutive stations

/// A crack between two planes through the thickness, projected.
class Window {
public:
  Window(double step, const std::vector<double>& spacing, const std::vector<std::vector<Trace>>& traces,
         double x_low, double x_high)
      : step_(step), spacing_(spacing), graph_(spacing, traces, x_low, x_high) {}

  std::vector<Detection> detections() const {
    std::vector<Detection> found;
    for (std::size_t k = 0; k + 1 < graph_.n_levels(); ++k) {
      for (std::size_t i = 0; i < graph_.at(k).size(); ++i) {
        if (graph_.at(k)[i].next.size() < 2) continue;
        const std::vector<Continuation> continuations = separate_continuations(k, graph_.at(k)[i]);
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
    return (graph_.at(k)[level.front()].low + graph_.at(k)[level.back()].high) / 2;
  }

  /// Continues from piece i of station k until the continuation is min_gap_length long; empty if it ends
  /// before.
  Continuation continuation_from(std::size_t k, std::size_t i) const {
    Continuation levels{{i}};
    const double start = middle(k, levels.front());
    for (std::size_t last = k;; ++last) {
      const double length =
          std::hypot(static_cast<double>(levels.size()) * step_, middle(last, levels.back()) - start);
      if (length >= min_gap_length * spacing_[k]) return levels;
      if (last + 1 >= graph_.n_levels()) return {};
      Level next = graph_.ahead(last, levels.back());
      if (next.empty()) return {};
      levels.push_back(std::move(next));
    }
  }

  /// The continuations of a piece that are long enough and have no piece in common, ordered across.
  std::vector<Continuation> separate_continuations(std::size_t k, const Piece& piece) const {
    std::vector<Continuation> continuations;
    for (const std::size_t j : piece.next) {
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
          graph_.at(k + level)[upper[level].front()].low - graph_.at(k + level)[lower[level].back()].high;
      widest = std::max(widest, gap / spacing_[k + level]);
    }
    return widest;
  }

  /// Follows both branches from station k until they end or meet.
  Detection follow(std::size_t k, const Continuation& lower, const Continuation& upper) const {
    Detection point{};
    point.advance = advance(k);
    point.across = (graph_.at(k)[lower.front().back()].high + graph_.at(k)[upper.front().front()].low) / 2;
    const double first_length = min_branch_length * spacing_[k];
    std::array<Level, 2> level{lower.front(), upper.front()};
    std::size_t station = k;
    for (;;) {
      for (std::size_t side = 0; side < 2; ++side)
        collect(point.branches[side], station, level[side], first_length);
      if (station + 1 >= graph_.n_levels()) break;
      std::array<Level, 2> next{graph_.ahead(station, level[0]), graph_.ahead(station, level[1])};
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

  /// Adds a station's pieces to a branch.
  /// @param first_length of the branch's first part
  void collect(Branch& branch, std::size_t station, const Level& level, double first_length) const {
    if (level.empty()) return;
    const double across = middle(station, level);
    branch.reach = advance(station);
    branch.line.emplace_back(branch.reach, across);
    const auto& [first_advance, first_across] = branch.line.front();
    const bool is_first = std::hypot(branch.reach - first_advance, across - first_across) <= first_length;
    for (const std::size_t i : level) {
      const Indices& facets = graph_.at(station)[i].facets;
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

  /// True if piece i of station k, where continuations separate, closely follows the place where the branches
  /// met.
  bool is_extended_at(const Detection& point, std::size_t k, std::size_t i) const {
    const auto soon = static_cast<std::size_t>(reunion_length * spacing_[k] / step_);
    if (point.reunited.empty() || k < point.last || k > point.last + soon) return false;
    Level level = point.reunited;
    for (std::size_t station = point.last; station < k; ++station) level = graph_.ahead(station, level);
    return std::binary_search(level.begin(), level.end(), i);
  }

  double step_;
  const std::vector<double>& spacing_;  ///< local spacing at every station
  CrackGraph graph_;                    ///< its levels are the stations
};

/// The facets of pieces of at least stray_size, where facets of the same tetrahedron or the same edge are
/// connected.
Indices without_strays(const CrackSurface& surface, const Indices& facets) {
  DisjointSets pieces(facets.size());
  std::map<geometry::Point, std::size_t> at_edge;
  std::map<std::int64_t, std::size_t> in_tetrahedron;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const CrackFacet& facet = surface.facets[facets[i]];
    for (const std::size_t other : {at_edge.try_emplace(facet.corner[0], i).first->second,
                                    in_tetrahedron.try_emplace(facet.tetrahedron, i).first->second})
      pieces.join(i, other);
  }
  struct Extent {
    geometry::Box box = geometry::nowhere;
    double spacing = 0;
    int n = 0;
  };
  std::vector<Extent> extents(facets.size());
  for (std::size_t i = 0; i < facets.size(); ++i) {
    Extent& extent = extents[pieces.smallest(i)];
    const CrackFacet& facet = surface.facets[facets[i]];
    for (const geometry::Point& p : facet.corner) extent.box.include(p);
    extent.spacing += local_spacing(facet);
    ++extent.n;
  }
  Indices kept;
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const Extent& extent = extents[pieces.smallest(i)];
    const double size = std::ranges::max(extent.box.upper - extent.box.lower);
    if (size >= stray_size * extent.spacing / extent.n) kept.push_back(facets[i]);
  }
  return kept;
}

/// Merges the same branch as detected in another window.
void add_branch(Branch& to, const Branch& from) {
  add(to.facets, from.facets);
  add(to.first, from.first);
  to.reach = std::max(to.reach, from.reach);
  to.length = std::max(to.length, from.length);
}

/// Finds the branching points of the crack on one ligament.
class BranchFinder {
public:
  BranchFinder(const geometry::Body& body, const CrackSurface& surface, const CrackLigament& ligament)
      : surface_(surface),
        number_(ligament.start),
        start_(ligament.line),
        thickness_(Projection(body).thickness()),
        mean_spacing_(mean_spacing(surface, ligament.facets)),
        step_(mean_spacing_ / stations_per_spacing),
        traces_(static_cast<std::size_t>(std::ceil(start_.ligament / step_))) {
    for (const std::size_t i : without_strays(surface, ligament.facets)) add_traces(i);
    measure_spacing();
  }

  void add_to(CrackBranches& found) const {
    const int n_windows =
        std::max(1, static_cast<int>(2 * thickness_ / (window_thickness * mean_spacing_)) - 1);
    const double half = thickness_ / (n_windows + 1);
    std::vector<Detection> seen;
    const auto detect = [&](int window, double low, double high) {
      for (Detection& point : Window(step_, spacing_, traces_, low, high).detections()) {
        point.window = window;
        seen.push_back(std::move(point));
      }
    };
    detect(projection, 0, thickness_);
    for (int w = 0; w < n_windows; ++w) detect(w, w * half, (w + 2) * half);
    std::vector<Merged> points = merge(seen);
    std::stable_sort(points.begin(), points.end(), [](const Merged& a, const Merged& b) {
      return std::pair(a.advance, a.across) < std::pair(b.advance, b.across);
    });
    for (const Merged& point : points) {
      if (is_long(point)) add_point(found, point);
    }
  }

private:
  /// All detections of one branching point.
  struct Merged {
    double advance = 0;
    double across = 0;
    double angle = 0;
    std::array<Branch, 2> branches;
    bool ends_apart = false;  ///< the branches do not meet again
    bool is_in_projection = false;
    bool is_in_space = false;
  };

  void add_traces(std::size_t facet) {
    const auto [low, high] = advances(surface_.facets[facet], start_);
    const std::size_t one[] = {facet};
    const auto last = static_cast<double>(traces_.size()) - 1;
    for (double k = std::max(0.0, std::floor(low / step_)); k <= std::min(high / step_, last); ++k) {
      for (const Trace& trace : intersect(surface_, one, start_.plane_at((k + 0.5) * step_)))
        traces_[static_cast<std::size_t>(k)].push_back(trace);
    }
  }

  /// Averages the spacing over the traces within two mean spacings of each station.
  void measure_spacing() {
    std::vector<double> sum{0};
    std::vector<double> n{0};
    for (const auto& at_station : traces_) {
      sum.push_back(sum.back());
      n.push_back(n.back() + static_cast<double>(at_station.size()));
      for (const Trace& trace : at_station) sum.back() += trace.spacing;
    }
    constexpr auto reach = static_cast<std::size_t>(2 * stations_per_spacing);
    for (std::size_t k = 0; k < traces_.size(); ++k) {
      const std::size_t low = k > reach ? k - reach : 0;
      const std::size_t high = std::min(k + reach + 1, traces_.size());
      spacing_.push_back(n[high] > n[low] ? (sum[high] - sum[low]) / (n[high] - n[low]) : mean_spacing_);
    }
  }

  /// Overlap of two detections, relative to the smaller branches.
  static double overlap(const Detection& a, const Detection& b) {
    double least = 1;
    for (std::size_t side = 0; side < 2; ++side) {
      const Indices& mine = a.branches[side].facets;
      const Indices& other = b.branches[side].facets;
      Indices both;
      std::set_intersection(mine.begin(), mine.end(), other.begin(), other.end(), std::back_inserter(both));
      least = std::min(
          least, static_cast<double>(both.size()) / static_cast<double>(std::min(mine.size(), other.size())));
    }
    return least;
  }

  /// True if one window shows both at the same advance: then they are different branching points. If one is
  /// behind the other they may be the same one, whose branches meet in between.
  static bool are_beside(const Detection& a, const Detection& b) {
    const auto end = [](const Detection& s) { return std::min(s.branches[0].reach, s.branches[1].reach); };
    return a.window == b.window && a.advance <= end(b) && b.advance <= end(a);
  }

  /// Merges detections into branching points, most similar ones first.
  static std::vector<Merged> merge(const std::vector<Detection>& seen) {
    struct Pair {
      double overlap;
      std::size_t i, j;
    };
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (const double found = overlap(seen[i], seen[j]); found >= min_overlap_of_windows)
          pairs.push_back({found, i, j});
      }
    }
    std::ranges::stable_sort(pairs, std::greater(), &Pair::overlap);
    std::vector<Indices> groups(seen.size());  // of detections
    std::vector<std::size_t> group_of(seen.size());
    for (std::size_t i = 0; i < seen.size(); ++i) groups[group_of[i] = i] = {i};
    for (const Pair& pair : pairs) {
      Indices& mine = groups[group_of[pair.i]];
      Indices& other = groups[group_of[pair.j]];
      const bool are_different = std::ranges::any_of(mine, [&](std::size_t i) {
        return std::ranges::any_of(other, [&](std::size_t j) { return are_beside(seen[i], seen[j]); });
      });
      if (&mine == &other || are_different) continue;
      for (const std::size_t j : other) group_of[j] = group_of[pair.i];
      add(mine, std::exchange(other, {}));
    }
    std::vector<Merged> points;
    for (const Indices& group : groups) {
      if (!group.empty()) points.push_back(merged(seen, group));
    }
    return points;
  }

  static Merged merged(const std::vector<Detection>& seen, const Indices& group) {
    // Joins successive detections in one window if another window shows that they are one.
    std::vector<Detection> in_windows;
    for (const std::size_t i : group) {
      if (in_windows.empty() || in_windows.back().window != seen[i].window)
        in_windows.push_back(seen[i]);
      else
        extend(in_windows.back(), seen[i]);
    }
    Merged point;
    double n = 0;
    for (const Detection& one : in_windows) {
      for (std::size_t side = 0; side < 2; ++side) add_branch(point.branches[side], one.branches[side]);
      point.ends_apart = point.ends_apart || one.reunited.empty();
      (one.window == projection ? point.is_in_projection : point.is_in_space) = true;
      // The projection comes first, and contains both whole branches.
      if (point.is_in_projection && n > 0) continue;
      n += 1;
      point.advance += (one.advance - point.advance) / n;
      point.across += (one.across - point.across) / n;
      point.angle += (one.angle - point.angle) / n;
    }
    return point;
  }

  bool is_long(const Merged& point) const {
    const auto station = static_cast<std::size_t>(point.advance / step_);
    return std::min(point.branches[0].length, point.branches[1].length) >=
           (point.ends_apart ? min_branch_length : reunion_length) * spacing_.at(station);
  }

  double area(const Indices& facets) const {
    double sum = 0;
    for (const std::size_t i : facets) sum += surface_.facets[i].area;
    return sum;
  }

  double median_time(const Indices& facets) const {
    std::vector<double> times;
    for (const std::size_t i : facets) times.push_back(surface_.facets[i].time);
    return median(std::move(times));
  }

  /// The branch to which most of these facets have been assigned so far.
  static std::int32_t branch_of(const CrackBranches& found, const Indices& facets) {
    std::map<std::int32_t, std::size_t> n;
    for (const std::size_t i : facets) ++n[found.branch[i]];
    return std::max_element(n.begin(), n.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }

  void add_point(CrackBranches& found, const Merged& seen) const {
    const double ahead = seen.branches[1].reach - seen.branches[0].reach;
    const bool upper_is_main = std::abs(ahead) > min_branch_length * mean_spacing_
                                   ? ahead > 0
                                   : area(seen.branches[1].facets) > area(seen.branches[0].facets);
    std::size_t secondary = upper_is_main ? 0 : 1;
    // With three branches, the middle one may already have been separated from this one.
    const std::array<std::int32_t, 2> known{branch_of(found, seen.branches[0].facets),
                                            branch_of(found, seen.branches[1].facets)};
    if (known[secondary] > known[1 - secondary]) secondary = 1 - secondary;

    const Branch& branch = seen.branches[secondary];
    found.points.emplace_back();
    BranchingPoint& point = found.points.back();
    point.start = number_;
    point.parent = known[secondary];
    std::tie(point.y, point.z) =
        std::tuple_cat(Projection::in_plane(start_.plane_at(seen.advance).at(seen.across)));
    point.time = std::max(median_time(seen.branches[0].first), median_time(seen.branches[1].first));
    point.length = branch.length;
    point.angle = seen.angle;
    geometry::Box box = geometry::nowhere;
    for (const std::size_t i : branch.facets) {
      found.branch[i] = static_cast<std::int32_t>(found.points.size());
      for (const geometry::Point& p : surface_.facets[i].corner) box.include(p);
    }
    const double low = Projection::depth(box.lower), high = Projection::depth(box.upper);
    point.x = (low + high) / 2;
    point.share = (high - low) / thickness_;
    point.is_in_projection = seen.is_in_projection;
    point.is_in_space = seen.is_in_space;
  }

  const CrackSurface& surface_;
  std::int32_t number_;
  const geometry::CrackStart& start_;
  double thickness_;
  double mean_spacing_;
  double step_;  ///< distance between stations [m]
  std::vector<std::vector<Trace>> traces_;
  std::vector<double> spacing_;
};

}  // namespace

CrackBranches find_branches(const geometry::Body& body, const CrackSurface& surface) {
  return find_branches(body, surface, crack_ligaments(body, surface));
}

CrackBranches find_branches(const geometry::Body& body, const CrackSurface& surface,
                            std::span<const CrackLigament> ligaments) {
  CrackBranches found;
  found.branch.assign(surface.facets.size(), 0);
  for (const CrackLigament& ligament : ligaments)
    if (!ligament.facets.empty()) BranchFinder(body, surface, ligament).add_to(found);
  return found;
}

}  // namespace crackle::cracks
