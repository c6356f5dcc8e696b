// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_line.h"

#include "slabs.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>
#include <utility>

namespace crackle::analysis {

namespace {

struct Place {
  std::size_t slab;
  std::size_t piece;
};

/// A notch's crack as slabs, and the lines drawn through them.
class Tracer {
public:
  Tracer(const geometry::Body& body, const CrackSurface& surface, int notch,
         std::span<const std::size_t> facets)
      : surface_(surface),
        notch_(notch),
        frame_(notch_frame(body, notch)),
        spacing_(mean_spacing(surface, facets)),
        thickness_(body.size()[0]),
        slabs_(cut_in_slabs(surface, facets, frame_, spacing_, thickness_)),
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
    // Branches of branches are found in turn: the list grows while it is worked off.
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

  /// Goes on from a place until the end, or on to a piece that another line has taken.
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
    CrackLine line{notch_, parent, {}, 0, 0};
    for (const Place& place : places) {
      const double position =
          frame_.tip + frame_.direction * (static_cast<double>(place.slab) + 0.5) * spacing_;
      const auto& facets = slabs_[place.slab][place.piece].facets;
      const auto traces = intersect(surface_, facets, frame_.axis, frame_.across, position);
      const auto crossing = main_crossing(traces, thickness_);
      if (!crossing) continue;  // rough edges of a piece can leave its middle free
      const bool across_z = frame_.across == 2;
      line.points.push_back({across_z ? position : crossing->mean, across_z ? crossing->mean : position,
                             crossing->spread, crossing->time});
    }
    measure_turns(line);
    lines.push_back(std::move(line));
  }

  /// Angle of the straight line through points first..first + direction_window - 1 to the notch's direction.
  double direction(const CrackLine& line, std::size_t first) const {
    double mean_advance = 0;
    double mean_across = 0;
    const auto window = std::span(line.points).subspan(first, direction_window);
    const auto coordinates = [&](const LinePoint& p) {
      return frame_.axis == 1 ? std::pair(frame_.advance(p.y), p.z) : std::pair(frame_.advance(p.z), p.y);
    };
    for (const LinePoint& p : window) {
      mean_advance += coordinates(p).first / direction_window;
      mean_across += coordinates(p).second / direction_window;
    }
    double product = 0;
    double square = 0;
    for (const LinePoint& p : window) {
      const double advance = coordinates(p).first - mean_advance;
      product += advance * (coordinates(p).second - mean_across);
      square += advance * advance;
    }
    return std::atan2(product, square);
  }

  void measure_turns(CrackLine& line) const {
    constexpr std::size_t n = direction_window;
    if (line.points.size() < 2 * n - 1) return;
    // Windows before and after a point share it.
    std::vector<double> directions;
    for (std::size_t i = 0; i + n <= line.points.size(); ++i) directions.push_back(direction(line, i));
    line.bend = directions.back() - directions.front();
    std::vector<double> turns;
    for (std::size_t i = 0; i + n - 1 < directions.size(); ++i) {
      turns.push_back(std::abs(directions[i + n - 1] - directions[i]));
    }
    for (std::size_t i = 0; i < turns.size(); ++i) {
      if (turns[i] < kink_angle) continue;
      const std::size_t low = i < n ? 0 : i - n;
      const std::size_t high = std::min(turns.size(), i + n + 1);
      const auto largest = std::max_element(turns.begin() + static_cast<std::ptrdiff_t>(low),
                                            turns.begin() + static_cast<std::ptrdiff_t>(high));
      if (largest - turns.begin() == static_cast<std::ptrdiff_t>(i)) ++line.kinks;
    }
  }

  const CrackSurface& surface_;
  int notch_;
  NotchFrame frame_;
  double spacing_;
  double thickness_;
  std::vector<Slab> slabs_;
  std::vector<std::vector<int>> n_ahead_;  ///< slabs that the longest way from each piece passes
  std::vector<std::vector<bool>> taken_;   ///< pieces that a line passes
};

}  // namespace

std::vector<CrackLine> crack_lines(const geometry::Body& body, const CrackSurface& surface) {
  std::vector<CrackLine> lines;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    if (!facets.empty()) Tracer(body, surface, notch, facets).trace(lines);
  }
  return lines;
}

std::int32_t count_kinks(const std::vector<CrackLine>& lines) {
  std::int32_t n_kinks = 0;
  for (const CrackLine& line : lines) n_kinks += line.kinks;
  return n_kinks;
}

}  // namespace crackle::analysis
