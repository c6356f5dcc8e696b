// SPDX-License-Identifier: GPL-3.0-or-later
#include "crack_graph.h"

#include "common/disjoint_sets.h"
#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "cracks/branching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <ranges>

namespace crackle::cracks {

namespace {

double gap(double a_low, double a_high, double b_low, double b_high) {
  return std::max({0.0, a_low - b_high, b_low - a_high});
}

bool are_near(const Trace& a, const Trace& b) {
  const double spacing = (a.spacing + b.spacing) / 2;
  if (gap(a.x[0], a.x[1], b.x[0], b.x[1]) > hole_size * spacing) return false;
  const auto [a_low, a_high] = std::minmax(a.across[0], a.across[1]);
  const auto [b_low, b_high] = std::minmax(b.across[0], b.across[1]);
  return gap(a_low, a_high, b_low, b_high) <= crossing_gap * spacing;
}

/// The ends of all traces, ascending: between two of them the set of traces is constant.
std::vector<double> ends(std::span<const Trace> traces, std::span<const std::size_t> members) {
  std::vector<double> x;
  for (const std::size_t i : members) x.insert(x.end(), {traces[i].x[0], traces[i].x[1]});
  std::sort(x.begin(), x.end());
  x.erase(std::unique(x.begin(), x.end()), x.end());
  return x;
}

/// Integrals over the covered thickness of 1, of the mean over the traces at equal x, of its square, and of
/// the first opening time.
struct Integrals {
  double length = 0;
  double first = 0;
  double second = 0;
  double time = 0;
  double dynamic_time = 0;  // with 0 for openings before the last dynamic phase
};

Integrals integrate(std::span<const Trace> traces, std::span<const std::size_t> members) {
  const std::vector<double> x = ends(traces, members);
  Integrals integrals;
  // Squares are taken relative to a nearby value, to preserve digits.
  const double origin = traces[members.front()].across[0];
  for (std::size_t k = 0; k + 1 < x.size(); ++k) {
    const double middle = (x[k] + x[k + 1]) / 2;
    double sum = 0;
    double slope = 0;
    double time = infinity;
    int n = 0;
    for (const std::size_t i : members) {
      const Trace& trace = traces[i];
      if (trace.x[0] > x[k] || trace.x[1] < x[k + 1]) continue;
      const double steepness = (trace.across[1] - trace.across[0]) / (trace.x[1] - trace.x[0]);
      sum += trace.across[0] + steepness * (middle - trace.x[0]);
      slope += steepness;
      time = std::min(time, trace.time);
      ++n;
    }
    if (n == 0) continue;
    const double length = x[k + 1] - x[k];
    const double value = sum / n - origin;
    const double rise = slope / n * length;
    integrals.length += length;
    integrals.time += time * length;
    integrals.dynamic_time += std::max(0.0, time) * length;
    integrals.first += value * length;
    integrals.second += (value * value + rise * rise / 12) * length;
  }
  return integrals;
}

/// The facets of cracks with this number of a start.
Indices facets_of(const CrackSurface& surface, std::int32_t start, auto number_of) {
  Indices facets;
  for (std::size_t i = 0; i < surface.facets.size(); ++i)
    if (std::invoke(number_of, surface.cracks[index(surface.facets[i].crack)]) == start) facets.push_back(i);
  return facets;
}

/// A facet's extent through the thickness and across, where the latter coordinate is dot(p, across).
Trace extent(const CrackSurface& surface, std::size_t facet, const Vector& across) {
  const auto range = [&](const auto& coordinate) {
    return std::ranges::minmax(surface.facets[facet].corner | std::views::transform(coordinate));
  };
  const auto x = range(&Projection::depth);
  const auto side = range([&](const geometry::Point& p) { return dot(p, across); });
  return {{x.min, x.max},
          {side.min, side.max},
          local_spacing(surface.facets[facet]),
          surface.facets[facet].time,
          facet};
}

}  // namespace

Indices facets_from(const CrackSurface& surface, std::int32_t start) {
  return facets_of(surface, start, &Crack::start);
}

Indices facets_begun_at(const CrackSurface& surface, std::int32_t start) {
  return facets_of(surface, start, &Crack::origin);
}

std::map<std::int32_t, Indices> by_branch(std::span<const std::size_t> facets,
                                          const CrackBranches& branches) {
  std::map<std::int32_t, Indices> found;
  for (const std::size_t i : facets) found[branches.branch[i]].push_back(i);
  return found;
}

double mean_spacing(const CrackSurface& surface, std::span<const std::size_t> facets) {
  double sum = 0;
  for (const std::size_t i : facets) sum += local_spacing(surface.facets[i]);
  return facets.empty() ? 0 : sum / static_cast<double>(facets.size());
}

std::optional<std::array<Passage, 2>> passages(const CrackFacet& facet, const Vector& normal,
                                               double position) {
  std::array<double, 4> along{};
  for (std::size_t k = 0; k < 4; ++k) along[k] = dot(facet.corner[k], normal);
  std::array<Passage, 2> found{};
  std::size_t n = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t next = (k + 1) % 4;
    // Half-open intervals, so that a corner on the plane belongs to only one of its sides; a convex facet
    // then has two intersected sides or none.
    if ((along[k] < position) == (along[next] < position) || n == 2) continue;
    found[n++] = {k, next, (position - along[k]) / (along[next] - along[k])};
  }
  if (n < 2) return {};
  return found;
}

std::vector<Trace> intersect(const CrackSurface& surface, std::span<const std::size_t> facets,
                             const geometry::CrossPlane& plane) {
  std::vector<Trace> traces;
  for (const std::size_t i : facets) {
    const CrackFacet& facet = surface.facets[i];
    const auto sides = passages(facet, plane.normal, plane.position);
    if (!sides) continue;
    std::array<std::pair<double, double>, 2> end;
    std::ranges::transform(*sides, end.begin(), [&](const Passage& passage) {
      const geometry::Point& a = facet.corner[passage.from];
      const geometry::Point& b = facet.corner[passage.to];
      const double side = plane.coordinate(a);
      const double depth = Projection::depth(a);
      return std::pair(depth + passage.share * (Projection::depth(b) - depth),
                       side + passage.share * (plane.coordinate(b) - side));
    });
    if (end[1].first < end[0].first) std::swap(end[0], end[1]);
    traces.push_back(
        {{end[0].first, end[1].first}, {end[0].second, end[1].second}, local_spacing(facet), facet.time, i});
  }
  return traces;
}

std::vector<std::vector<std::size_t>> group(std::span<const Trace> traces, double thickness) {
  DisjointSets sets(traces.size());
  for (std::size_t i = 0; i < traces.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      if (are_near(traces[i], traces[j])) sets.join(i, j);
  }
  std::vector<std::vector<std::size_t>> members(traces.size());
  for (std::size_t i = 0; i < traces.size(); ++i) members[sets.smallest(i)].push_back(i);
  std::erase_if(members, [&](const auto& some) {
    return some.empty() || integrate(traces, some).length < min_thickness_share * thickness;
  });
  return members;
}

std::pair<double, double> advances(const CrackFacet& facet, const geometry::CrackStart& start) {
  std::array<double, 4> advance{};
  std::ranges::transform(facet.corner, advance.begin(),
                         [&](const geometry::Point& corner) { return start.advance(corner); });
  const auto [low, high] = std::ranges::minmax(advance);
  return {low, high};
}

void sort_unique(Indices& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

bool intersects(const Indices& a, const Indices& b) {
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) return true;
    *i < *j ? ++i : ++j;
  }
  return false;
}

void add(Indices& to, const Indices& from) {
  to.insert(to.end(), from.begin(), from.end());
  sort_unique(to);
}

std::optional<Crossing> main_crossing(std::span<const Trace> traces, double thickness,
                                      std::span<const std::int32_t> branch,
                                      const geometry::CrossPlane* plane) {
  struct Part {
    BranchCrossing crossing;
    double spread;
    double time;
    double arrival;
  };
  std::vector<Part> parts;
  std::map<std::int32_t, double> largest;  // share of each branch
  for (const auto& group_members : group(traces, thickness)) {
    std::map<std::int32_t, std::vector<std::size_t>> branches;
    for (const std::size_t i : group_members)
      branches[branch.empty() ? 0 : branch[traces[i].facet]].push_back(i);
    for (const auto& [number, members] : branches) {
      const Integrals found = integrate(traces, members);
      if (!(found.length > 0)) continue;
      const double mean = found.first / found.length;
      if (plane != nullptr && !plane->holds(traces[members.front()].across[0] + mean)) continue;
      const double variance = std::max(0.0, found.second / found.length - mean * mean);
      const double share = found.length / thickness;
      parts.push_back({{traces[members.front()].across[0] + mean, share, number},
                       std::sqrt(variance),
                       traces[group_members.front()].time,
                       (found.dynamic_time > 0 ? found.dynamic_time : found.time) / found.length});
      largest[number] = std::max(largest[number], share);
    }
  }
  // Remains of a branch next to another one are not a separate crossing.
  std::erase_if(parts, [&](const Part& part) {
    const double share = part.crossing.share;
    return share < (share == largest[part.crossing.branch] ? min_branch_share : min_thickness_share);
  });
  if (parts.empty()) return std::nullopt;
  // Traces are in order of breaking and groups in order of their first trace, so among parts of equal
  // coverage the earliest is the main one.
  const auto rank = [](const Part& part) {
    return std::pair(part.crossing.branch == 0, part.crossing.share);
  };
  const Part& main = *std::ranges::max_element(parts, {}, rank);
  Crossing crossing{main.crossing.position, main.spread, main.time, main.arrival, {}};
  for (const Part& part : parts) crossing.branches.push_back(part.crossing);
  std::ranges::stable_sort(crossing.branches, {}, &BranchCrossing::position);
  return crossing;
}

CrackGraph::CrackGraph(const Projection& projection, const CrackSurface& surface,
                       std::span<const std::size_t> facets, const geometry::CrackStart& line, double spacing)
    : levels_(static_cast<std::size_t>(std::ceil(line.ligament / spacing))) {
  std::vector<std::vector<Trace>> traces(levels_.size());
  for (const std::size_t i : facets) {
    const auto [low, high] = advances(surface.facets[i], line);
    if (high < 0 || low >= line.ligament) continue;
    const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(low / spacing)));
    const auto last = std::min(static_cast<std::size_t>(std::floor(high / spacing)), levels_.size() - 1);
    const Trace box = extent(surface, i, line.across);
    for (std::size_t k = first; k <= last; ++k) traces[k].push_back(box);
  }
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    for (const auto& members : group(traces[k], projection.thickness())) {
      Piece& piece = levels_[k].emplace_back();
      piece.low = infinity, piece.high = -infinity;
      for (const std::size_t i : members) {
        piece.facets.push_back(traces[k][i].facet);
        piece.low = std::min(piece.low, traces[k][i].across[0]);
        piece.high = std::max(piece.high, traces[k][i].across[1]);
      }
    }
  }
  connect([](const Piece& a, const Piece& b) { return intersects(a.facets, b.facets); });
}

CrackGraph::CrackGraph(std::span<const double> spacing, const std::vector<std::vector<Trace>>& traces,
                       double x_low, double x_high)
    : levels_(traces.size()) {
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
    std::ranges::sort(seen);
    for (const auto& [range, facet] : seen) {
      if (levels_[k].empty() || range.first > levels_[k].back().high + branch_gap * spacing[k])
        levels_[k].push_back({{}, range.first, range.second, {}});
      Piece& piece = levels_[k].back();
      piece.high = std::max(piece.high, range.second);
      piece.facets.push_back(facet);
    }
    for (Piece& piece : levels_[k]) sort_unique(piece.facets);
  }
  connect([](const Piece& a, const Piece& b) { return b.low <= a.high && a.low <= b.high; });
}

void CrackGraph::connect(const auto& are_connected) {
  for (std::size_t k = 0; k + 1 < levels_.size(); ++k)
    for (Piece& piece : levels_[k])
      for (std::size_t j = 0; j < levels_[k + 1].size(); ++j)
        if (are_connected(piece, levels_[k + 1][j])) piece.next.push_back(j);
}

Indices CrackGraph::ahead(std::size_t level, const Indices& pieces) const {
  Indices next;
  for (const std::size_t i : pieces)
    next.insert(next.end(), levels_[level][i].next.begin(), levels_[level][i].next.end());
  sort_unique(next);
  return next;
}

Path CrackGraph::longest_path(bool from_first) const {
  std::vector<std::vector<std::size_t>> n_ahead(
      levels_.size());  // levels of the longest path from each piece
  const auto longest = [&](std::size_t level, const Indices& pieces) {
    return *std::ranges::max_element(pieces, {}, [&](std::size_t piece) { return n_ahead[level][piece]; });
  };
  std::size_t level = levels_.size(), first = 0;
  for (std::size_t k = levels_.size(); k-- > 0;) {
    for (const Piece& piece : levels_[k])
      n_ahead[k].push_back(1 + (piece.next.empty() ? 0 : n_ahead[k + 1][longest(k + 1, piece.next)]));
    if (levels_[k].empty()) continue;
    const auto best = std::ranges::max_element(n_ahead[k]);
    if (!from_first && level < levels_.size() && *best < n_ahead[level][first]) continue;
    level = k;
    first = static_cast<std::size_t>(best - n_ahead[k].begin());
  }
  Path path;
  for (std::size_t piece = first; level < levels_.size(); ++level) {
    const Piece& here = levels_[level][piece];
    path.push_back({level, here.facets});
    if (here.next.empty()) break;
    piece = longest(level + 1, here.next);
  }
  return path;
}

}  // namespace crackle::cracks
