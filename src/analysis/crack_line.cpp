// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_line.h"

#include "crackle/analysis/crack_ligaments.h"
#include "crackle/analysis/crack_path.h"
#include "crackle/common/index.h"

#include "crossings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <numbers>
#include <span>
#include <utility>

namespace crackle::analysis {

namespace {

/// A connected piece of a crack in one slab, with the pieces of the next slab that share a facet with it.
struct Piece {
  Numbers facets;
  Numbers next;  ///< indices into the next slab
};
using Slab = std::vector<Piece>;

/// Facets of a crack, cut into slabs of thickness `spacing` along its advance, starting at the tip.
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

/// The facets of a line in one slab.
struct Place {
  std::size_t slab;
  Numbers facets;
};

/// The longest chain of connected pieces; among equals the one nearest to the tip.
/// @param from_first start in the first slab that has pieces
std::vector<Place> longest_chain(std::vector<Slab> slabs, bool from_first) {
  std::vector<std::vector<std::size_t>> n_ahead(slabs.size());  // slabs of the longest chain from each piece
  const auto longest = [&](std::size_t slab, const Numbers& pieces) {
    return *std::ranges::max_element(pieces, {}, [&](std::size_t piece) { return n_ahead[slab][piece]; });
  };
  std::size_t slab = slabs.size(), first = 0;
  for (std::size_t k = slabs.size(); k-- > 0;) {
    for (const Piece& piece : slabs[k])
      n_ahead[k].push_back(1 + (piece.next.empty() ? 0 : n_ahead[k + 1][longest(k + 1, piece.next)]));
    if (slabs[k].empty()) continue;
    const auto best = std::ranges::max_element(n_ahead[k]);
    if (!from_first && slab < slabs.size() && *best < n_ahead[slab][first]) continue;
    slab = k;
    first = static_cast<std::size_t>(best - n_ahead[k].begin());
  }
  std::vector<Place> chain;
  for (std::size_t piece = first; slab < slabs.size(); ++slab) {
    Piece& here = slabs[slab][piece];
    chain.push_back({slab, std::move(here.facets)});
    if (here.next.empty()) break;
    piece = longest(slab + 1, here.next);
  }
  return chain;
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

  explicit Polyline(std::vector<Place> places) : places_(std::move(places)), arc_length_{0} {
    for (std::size_t i = 1; i < places_.size(); ++i) {
      arc_length_.push_back(arc_length_.back() + std::hypot(places_[i].advance - places_[i - 1].advance,
                                                            places_[i].across - places_[i - 1].across));
    }
  }

  double length() const { return arc_length_.back(); }

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
      const double end = i + 1 < places_.size() ? std::min(arc_length_[i], to) : to;
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
  std::size_t segment(double length) const {
    const auto end = std::upper_bound(arc_length_.begin() + 1, arc_length_.end() - 1, length);
    return static_cast<std::size_t>(end - arc_length_.begin());
  }

  Place at(double length) const {
    const std::size_t i = segment(length);
    const double share = (length - arc_length_[i - 1]) / (arc_length_[i] - arc_length_[i - 1]);
    return {places_[i - 1].advance + share * (places_[i].advance - places_[i - 1].advance),
            places_[i - 1].across + share * (places_[i].across - places_[i - 1].across)};
  }

  std::vector<Place> places_;
  std::vector<double> arc_length_;  ///< arc length at each point [m]
};

/// The angle from one direction to another, in [-pi, pi] [rad].
double deflection(double from, double to) {
  return std::remainder(to - from, 2 * std::numbers::pi);
}

/// Traces the lines of the branches of the crack on one ligament.
class Tracer {
public:
  Tracer(const geometry::Body& body, const CrackSurface& surface, const CrackLigament& ligament)
      : surface_(surface),
        ligament_(ligament),
        start_(ligament.line),
        spacing_(mean_spacing(surface, ligament.facets)),
        thickness_(body.size()[0]) {}

  /// Adds the main line and its branches to `lines`.
  void trace(std::vector<CrackLine>& lines, const CrackBranches& branches) const {
    std::map<std::int32_t, Numbers> facets_of;
    for (const std::size_t i : ligament_.facets) facets_of[branches.branch[i]].push_back(i);
    struct Traced {
      std::size_t line;
      std::vector<Place> places;
    };
    std::map<std::int32_t, Traced> traced;
    // A branch has a higher number than the one it leaves.
    for (const auto& [branch, facets] : facets_of) {
      std::vector<Place> places =
          longest_chain(cut_in_slabs(surface_, facets, start_, spacing_, thickness_), branch == 0);
      if (places.empty()) continue;
      auto parent = traced.end();
      for (std::int32_t left = branch; left > 0 && parent == traced.end();)
        parent = traced.find(left = branches.points[index(left - 1)].parent);
      std::int32_t parent_line = -1;
      if (parent != traced.end()) {
        parent_line = static_cast<std::int32_t>(parent->second.line);
        const auto& along = parent->second.places;
        const auto beyond = std::ranges::lower_bound(along, places.front().slab, {}, &Place::slab);
        if (beyond != along.begin()) places.insert(places.begin(), *std::prev(beyond));
      }
      add(lines, parent_line, places);
      traced[branch] = {lines.size() - 1, std::move(places)};
    }
  }

private:
  void add(std::vector<CrackLine>& lines, std::int32_t parent, const std::vector<Place>& places) const {
    CrackLine line{ligament_.start, parent, {}, 0, 0};
    std::vector<Polyline::Place> path;
    for (const Place& place : places) {
      for (int i = 0; i < n_stations_per_slab; ++i) {
        const double advance = (static_cast<double>(place.slab) + (i + 0.5) / n_stations_per_slab) * spacing_;
        const geometry::CrossPlane plane = start_.plane_at(advance);
        const auto traces = intersect(surface_, place.facets, plane);
        const auto crossing = main_crossing(traces, thickness_);
        if (!crossing) continue;  // the rough edges of a piece can leave gaps
        path.push_back({advance, crossing->mean});
        if (i != n_stations_per_slab / 2) continue;
        const geometry::Point p = plane.at(crossing->mean);
        line.points.push_back({p[1], p[2], crossing->spread, crossing->arrival});
      }
    }
    if (path.size() > 1) measure_deflections(line, Polyline(std::move(path)));
    lines.push_back(std::move(line));
  }

  void measure_deflections(CrackLine& line, const Polyline& path) const {
    const double window = std::max(kink_window_share * start_.ligament, kink_window_spacings * spacing_);
    if (path.length() < 2 * window) return;
    line.bend = deflection(path.direction(0, window), path.direction(path.length() - window, path.length()));

    constexpr std::ptrdiff_t n_steps = 16;  // per window
    std::vector<double> deflections;
    for (double place = window; place <= path.length() - window; place += window / n_steps) {
      deflections.push_back(
          std::abs(deflection(path.direction(place - window, place), path.direction(place, place + window))));
    }
    for (auto here = deflections.begin(); here != deflections.end(); ++here) {
      if (*here < kink_angle) continue;
      const auto low = here - std::min(n_steps, here - deflections.begin());
      const auto high = here + std::min(n_steps + 1, deflections.end() - here);
      if (std::max_element(low, high) == here) ++line.kinks;
    }
  }

  const CrackSurface& surface_;
  const CrackLigament& ligament_;
  const geometry::CrackStart& start_;
  double spacing_;
  double thickness_;
};

}  // namespace

std::vector<CrackLine> crack_lines(const geometry::Body& body, const CrackSurface& surface,
                                   const CrackBranches& branches) {
  std::vector<CrackLine> lines;
  for (const CrackLigament& ligament : crack_ligaments(body, surface))
    if (!ligament.facets.empty()) Tracer(body, surface, ligament).trace(lines, branches);
  return lines;
}

std::int32_t count_kinks(const std::vector<CrackLine>& lines) {
  std::int32_t n_kinks = 0;
  for (const CrackLine& line : lines) n_kinks += line.kinks;
  return n_kinks;
}

}  // namespace crackle::analysis
