// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_line.h"

#include "crackle/analysis/crack_path.h"
#include "crackle/analysis/crack_ways.h"
#include "crackle/common/index.h"

#include "crossings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <utility>

namespace crackle::analysis {

namespace {

/// A connected piece of a crack in one slab, with the pieces of the next slab that share a facet with it.
struct Piece {
  std::vector<std::size_t> facets;  ///< ascending
  std::vector<std::size_t> next;    ///< indices into the next slab, ascending
};
using Slab = std::vector<Piece>;

/// A continuation: the pieces of the next slabs that it passes, over min_branch_length slabs.
using Way = std::vector<std::vector<std::size_t>>;

/// The pieces of slabs k, k + 1, ... on ways from piece `start` of slab k, over at most min_branch_length
/// slabs.
Way pieces_ahead(const std::vector<Slab>& slabs, std::size_t k, std::size_t start) {
  Way levels{{start}};
  while (levels.size() < min_branch_length && k + levels.size() < slabs.size()) {
    const Slab& slab = slabs[k + levels.size() - 1];
    std::vector<std::size_t> reached;
    for (const std::size_t piece : levels.back()) {
      reached.insert(reached.end(), slab[piece].next.begin(), slab[piece].next.end());
    }
    if (reached.empty()) break;
    sort_out(reached);
    levels.push_back(std::move(reached));
  }
  return levels;
}

/// The crack from a crack start, cut into slabs of thickness `spacing` along its advance, starting at the
/// tip.
std::vector<Slab> cut_in_slabs(const CrackSurface& surface, std::span<const std::size_t> facets,
                               const geometry::CrackStart& start, double spacing, double thickness) {
  const auto n_slabs = static_cast<std::size_t>(std::ceil(start.ligament / spacing));
  std::vector<std::vector<Trace>> traces(n_slabs);
  for (const std::size_t i : facets) {
    const auto [low, high] = advances(surface.facets[i], start);
    if (high < 0 || low >= start.ligament) continue;
    const auto first = static_cast<std::size_t>(std::max(0.0, std::floor(low / spacing)));
    const auto last = std::min(static_cast<std::size_t>(std::floor(high / spacing)), n_slabs - 1);
    const Trace box = extent(surface, i, start.across);
    for (std::size_t k = first; k <= last; ++k) traces[k].push_back(box);
  }
  std::vector<Slab> slabs(n_slabs);
  for (std::size_t k = 0; k < n_slabs; ++k) {
    for (const auto& members : group(traces[k], thickness)) {
      Piece piece;
      for (const std::size_t i : members) piece.facets.push_back(traces[k][i].facet);
      slabs[k].push_back(std::move(piece));
    }
  }
  for (std::size_t k = 0; k + 1 < n_slabs; ++k) {
    for (Piece& piece : slabs[k]) {
      for (std::size_t j = 0; j < slabs[k + 1].size(); ++j) {
        if (have_common(piece.facets, slabs[k + 1][j].facets)) piece.next.push_back(j);
      }
    }
  }
  return slabs;
}

/// The continuations of a piece of slab k that are long enough and have no piece in common.
std::vector<Way> separate_ways(const std::vector<Slab>& slabs, std::size_t k, const Piece& piece) {
  std::vector<Way> ways;
  for (const std::size_t j : piece.next) {
    Way way = pieces_ahead(slabs, k + 1, j);
    if (way.size() < min_branch_length) continue;
    // A way that soon meets an earlier one is the same branch; it may connect several earlier ones.
    for (std::size_t i = 0; i < ways.size();) {
      bool meet = false;
      for (std::size_t level = 0; level < min_branch_length; ++level) {
        meet = meet || have_common(ways[i][level], way[level]);
      }
      if (!meet) {
        ++i;
        continue;
      }
      for (std::size_t level = 0; level < min_branch_length; ++level) add(way[level], ways[i][level]);
      ways.erase(ways.begin() + static_cast<std::ptrdiff_t>(i));
      i = 0;
    }
    ways.push_back(std::move(way));
  }
  return ways;
}

/// Stations per slab at which a path's direction is measured; the middle one is the line's point.
constexpr int n_stations_per_slab = 3;

/// A path in the plane of the plate, straight between its points.
class Polyline {
public:
  struct Place {
    double advance;  ///< [m]
    double across;   ///< [m]
  };

  explicit Polyline(std::vector<Place> places) : places_(std::move(places)), way_{0} {
    for (std::size_t i = 1; i < places_.size(); ++i) {
      way_.push_back(way_.back() + std::hypot(places_[i].advance - places_[i - 1].advance,
                                              places_[i].across - places_[i - 1].across));
    }
  }

  double length() const { return way_.back(); }

  /// Angle to the advance of the straight line fitted to a part of the path by total least squares [rad].
  /// @param from,to arc lengths along the path
  double direction(double from, double to) const {
    const Place start = at(from);
    const double length = to - from;
    Place a{0, 0};  // relative to the start
    Place mean{0, 0};
    double advance_square = 0;
    double product = 0;
    double across_square = 0;
    for (std::size_t i = segment(from); from < to; ++i) {
      const double end = i + 1 < places_.size() ? std::min(way_[i], to) : to;
      const Place b{at(end).advance - start.advance, at(end).across - start.across};
      const double share = (end - from) / length;
      mean.advance += share * (a.advance + b.advance) / 2;
      mean.across += share * (a.across + b.across) / 2;
      // Simpson's rule is exact for the squares on a straight piece.
      const Place middle{(a.advance + b.advance) / 2, (a.across + b.across) / 2};
      for (const auto& [p, weight] : {std::pair{a, share / 6}, {middle, share * 4 / 6}, {b, share / 6}}) {
        advance_square += weight * p.advance * p.advance;
        product += weight * p.advance * p.across;
        across_square += weight * p.across * p.across;
      }
      a = b;
      from = end;
    }
    const double angle = std::atan2(2 * (product - mean.advance * mean.across),
                                    (advance_square - mean.advance * mean.advance) -
                                        (across_square - mean.across * mean.across)) /
                         2;
    // An axis has two directions: choose the one along the path.
    const bool is_backward = std::cos(angle) * a.advance + std::sin(angle) * a.across < 0;
    return is_backward ? angle + std::numbers::pi : angle;
  }

private:
  /// The segment that contains an arc length, by the index of its end.
  std::size_t segment(double way) const {
    const auto end = std::upper_bound(way_.begin() + 1, way_.end() - 1, way);
    return static_cast<std::size_t>(end - way_.begin());
  }

  Place at(double way) const {
    const std::size_t i = segment(way);
    const double share = (way - way_[i - 1]) / (way_[i] - way_[i - 1]);
    return {places_[i - 1].advance + share * (places_[i].advance - places_[i - 1].advance),
            places_[i - 1].across + share * (places_[i].across - places_[i - 1].across)};
  }

  std::vector<Place> places_;
  std::vector<double> way_;  ///< arc length at each point [m]
};

/// The angle from one direction to another, in [-pi, pi] [rad].
double turn(double from, double to) {
  return std::remainder(to - from, 2 * std::numbers::pi);
}

struct Place {
  std::size_t slab;
  std::size_t piece;
};

/// Divides the crack on one way into slabs and traces lines through them.
class Tracer {
public:
  Tracer(const geometry::Body& body, const CrackSurface& surface, const CrackWay& way)
      : surface_(surface),
        number_(way.notch),
        start_(way.line),
        spacing_(mean_spacing(surface, way.facets)),
        thickness_(body.size()[0]),
        slabs_(cut_in_slabs(surface, way.facets, start_, spacing_, thickness_)),
        n_ahead_(slabs_.size()),
        taken_(slabs_.size()) {
    for (std::size_t k = slabs_.size(); k-- > 0;) {
      taken_[k].assign(slabs_[k].size(), false);
      for (const Piece& piece : slabs_[k]) {
        int longest = 0;
        for (const std::size_t j : piece.next) longest = std::max(longest, n_ahead_[k + 1][j]);
        n_ahead_[k].push_back(1 + longest);
      }
    }
  }

  /// Adds the main line and its branches to `lines`.
  void trace(std::vector<CrackLine>& lines) {
    std::size_t first = 0;
    while (first < slabs_.size() && slabs_[first].empty()) ++first;
    if (first == slabs_.size()) return;
    std::vector<std::size_t> all(slabs_[first].size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    std::vector<Place> places;
    follow({first, longest(first, all)}, places);
    const std::size_t main = lines.size();
    add(lines, -1, places);
    // Branches of branches are found in turn: the list grows while it is processed.
    std::vector<std::pair<std::size_t, std::vector<Place>>> open{{main, places}};
    for (std::size_t i = 0; i < open.size(); ++i) {
      const auto [parent, along] = open[i];
      for (const Place& place : along) {
        const auto ways = separate_ways(slabs_, place.slab, slabs_[place.slab][place.piece]);
        if (ways.size() < 2) continue;
        for (const Way& way : ways) {
          const auto is_taken = [&](std::size_t j) { return taken_[place.slab + 1][j]; };
          if (std::any_of(way.front().begin(), way.front().end(), is_taken)) continue;
          std::vector<Place> branch{place};
          follow({place.slab + 1, longest(place.slab + 1, way.front())}, branch);
          open.emplace_back(lines.size(), branch);
          add(lines, static_cast<std::int32_t>(parent), branch);
        }
      }
    }
  }

private:
  std::size_t longest(std::size_t slab, const std::vector<std::size_t>& pieces) const {
    return *std::max_element(pieces.begin(), pieces.end(), [&](std::size_t a, std::size_t b) {
      return n_ahead_[slab][a] < n_ahead_[slab][b];
    });
  }

  /// Follows the crack from a piece until its end, or up to a piece already taken by another line.
  void follow(Place place, std::vector<Place>& places) {
    for (;;) {
      places.push_back(place);
      if (taken_[place.slab][place.piece]) return;
      taken_[place.slab][place.piece] = true;
      const Piece& piece = slabs_[place.slab][place.piece];
      if (piece.next.empty()) return;
      place = {place.slab + 1, longest(place.slab + 1, piece.next)};
    }
  }

  void add(std::vector<CrackLine>& lines, std::int32_t parent, const std::vector<Place>& places) const {
    CrackLine line{number_, parent, {}, 0, 0};
    std::vector<Polyline::Place> path;
    for (const Place& place : places) {
      const auto& facets = slabs_[place.slab][place.piece].facets;
      for (int i = 0; i < n_stations_per_slab; ++i) {
        const double advance = (static_cast<double>(place.slab) + (i + 0.5) / n_stations_per_slab) * spacing_;
        const geometry::CrossPlane plane = start_.plane_at(advance);
        const auto traces = intersect(surface_, facets, plane);
        const auto crossing = main_crossing(traces, thickness_);
        if (!crossing) continue;  // the rough edges of a piece can leave gaps
        path.push_back({advance, crossing->mean});
        if (i != n_stations_per_slab / 2) continue;
        const geometry::Point p = plane.at(crossing->mean);
        line.points.push_back({p[1], p[2], crossing->spread, crossing->arrival});
      }
    }
    if (path.size() > 1) measure_turns(line, Polyline(std::move(path)));
    lines.push_back(std::move(line));
  }

  void measure_turns(CrackLine& line, const Polyline& path) const {
    const double window = std::max(kink_window_share * start_.ligament, kink_window_spacings * spacing_);
    if (path.length() < 2 * window) return;
    line.bend = turn(path.direction(0, window), path.direction(path.length() - window, path.length()));

    constexpr std::ptrdiff_t n_steps = 16;  // per window
    std::vector<double> turns;
    for (double place = window; place <= path.length() - window; place += window / n_steps) {
      turns.push_back(
          std::abs(turn(path.direction(place - window, place), path.direction(place, place + window))));
    }
    for (auto here = turns.begin(); here != turns.end(); ++here) {
      if (*here < kink_angle) continue;
      const auto low = here - std::min(n_steps, here - turns.begin());
      const auto high = here + std::min(n_steps + 1, turns.end() - here);
      if (std::max_element(low, high) == here) ++line.kinks;
    }
  }

  const CrackSurface& surface_;
  std::int32_t number_;
  const geometry::CrackStart& start_;
  double spacing_;
  double thickness_;
  std::vector<Slab> slabs_;
  std::vector<std::vector<int>> n_ahead_;  ///< slabs on the longest way from each piece
  std::vector<std::vector<bool>> taken_;   ///< pieces on a line
};

}  // namespace

std::vector<CrackLine> crack_lines(const geometry::Body& body, const CrackSurface& surface) {
  std::vector<CrackLine> lines;
  for (const CrackWay& way : crack_ways(body, surface))
    if (!way.facets.empty()) Tracer(body, surface, way).trace(lines);
  return lines;
}

std::int32_t count_kinks(const std::vector<CrackLine>& lines) {
  std::int32_t n_kinks = 0;
  for (const CrackLine& line : lines) n_kinks += line.kinks;
  return n_kinks;
}

}  // namespace crackle::analysis
