// SPDX-License-Identifier: GPL-3.0-or-later
#include "crack_way.h"

#include "crackle/analysis/branching.h"
#include "crackle/analysis/crack_ligaments.h"
#include "crackle/analysis/crack_path.h"
#include "crackle/common/index.h"
#include "crackle/common/vector.h"

#include "crack_chain.h"
#include "crossings.h"
#include "polyline.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace crackle::analysis {

namespace {

Polyline::Place operator-(const Polyline::Place& a, const Polyline::Place& b) {
  return {a.advance - b.advance, a.across - b.across};
}

/// A chain's steps from one branch to another beside it.
class SideSteps {
public:
  /// Takes the steps out of the path: what is left of each is as long as a crack can run meanwhile.
  /// @param reached when the crack had opened at each place or farther on [s]
  SideSteps(std::vector<Polyline::Place>& path, const std::vector<double>& reached, double spacing,
            double rayleigh_speed) {
    Polyline::Place last = path.front(), out{0, 0};
    for (std::size_t i = 1; i < path.size();) {
      // To the next place at which the crack was before it was farther on.
      std::size_t next = i;
      while (next + 1 < path.size() && reached[next + 1] == reached[i]) ++next;
      const Polyline::Place here = path[next];
      const double ahead = here.advance - last.advance, step = here.across - last.across;
      const double run = rayleigh_speed * (reached[next] - reached[i - 1]);
      if (std::abs(step) > 2 * spacing && std::hypot(ahead, step) > run) {
        const double pace = std::clamp(run, 0.01 * ahead, ahead) / static_cast<double>(next + 1 - i);
        for (std::size_t k = i; k <= next; ++k) path[k] = {path[k - 1].advance + pace, path[k - 1].across};
        out = here - path[next];
        steps_.push_back({last.advance + ahead / 2, out});
      } else {
        for (std::size_t k = i; k <= next; ++k) path[k] = path[k] - out;
      }
      last = here;
      i = next + 1;
    }
  }

  /// A place without the steps before it.
  Polyline::Place without(const Polyline::Place& place) const {
    const auto next = std::ranges::upper_bound(steps_, place.advance, {}, &Step::at);
    return next == steps_.begin() ? place : place - std::prev(next)->out;
  }

private:
  struct Step {
    double at;            ///< advance [m]
    Polyline::Place out;  ///< sum of what has been taken out up to there
  };
  std::vector<Step> steps_;
};

/// The opened tetrahedra of these facets, sorted so that the order of simultaneous breaks has no influence.
/// @param facets in order of breaking
/// @param path,steps,first of the crack along its chord `line`, and the place where the path begins
std::vector<CrackWay::Opened> opened_by(const CrackSurface& surface, std::span<const std::size_t> facets,
                                        const geometry::CrackStart& line, const Polyline& path,
                                        const SideSteps& steps, double first) {
  std::vector<CrackWay::Opened> all;
  for (std::size_t i = 0; i < facets.size();) {
    const CrackFacet& facet = surface.facets[facets[i]];
    CrackWay::Opened opened{facet.time, 0, {facet.corner[0][0], facet.corner[0][0]}};
    geometry::Point sum{};
    double n = 0;
    for (; i < facets.size(); ++i) {
      const CrackFacet& other = surface.facets[facets[i]];
      if (other.tetrahedron != facet.tetrahedron || other.time != facet.time) break;
      for (const geometry::Point& corner : other.corner) {
        sum = sum + corner;
        opened.x[0] = std::min(opened.x[0], corner[0]);
        opened.x[1] = std::max(opened.x[1], corner[0]);
        n += 1;
      }
    }
    const geometry::Point middle = sum / n;
    opened.place = first + path.foot(steps.without({line.advance(middle), dot(middle, line.across)}));
    all.push_back(opened);
  }
  std::ranges::sort(all, {}, [](const CrackWay::Opened& o) { return std::tie(o.time, o.place, o.x); });
  return all;
}

}  // namespace

std::vector<CrackWay> crack_ways(const geometry::Body& body, const CrackSurface& surface,
                                 double rayleigh_speed) {
  std::vector<CrackWay> ways;
  const double thickness = body.size()[0];
  std::vector<CrackLigament> chords = crack_chords(body, surface);
  const CrackBranches branches = find_branches(body, surface, chords);
  for (CrackLigament& chord : chords) {
    std::erase_if(chord.facets, [&](std::size_t i) { return branches.branch[i] > 0; });
    const geometry::CrackStart& line = chord.line;
    const double spacing = mean_spacing(surface, chord.facets);
    std::vector<Polyline::Place> places;
    std::vector<double> times;
    Numbers facets;
    for (const ChainLink& link : longest_chain(surface, chord.facets, line, spacing, thickness, false)) {
      facets.insert(facets.end(), link.facets.begin(), link.facets.end());
      const double advance = (static_cast<double>(link.slab) + 0.5) * spacing;
      const auto crossing = main_crossing(intersect(surface, link.facets, line.plane_at(advance)), thickness);
      if (!crossing) continue;  // the rough edges of a piece can leave gaps
      places.push_back({advance, crossing->mean});
      times.push_back(crossing->arrival);
    }
    if (places.size() < 2) continue;
    sort_out(facets);
    std::vector<double> reached = times;
    for (std::size_t i = reached.size() - 1; i-- > 0;) reached[i] = std::min(reached[i], reached[i + 1]);
    const SideSteps steps(places, reached, spacing, rayleigh_speed);
    const Polyline path = Polyline(std::move(places)).smoothed(way_smoothing * spacing);
    const double first = std::hypot(path.front().advance, path.front().across - dot(line.tip, line.across));
    const geometry::CrackStart& start = body.crack_starts()[index(chord.origin)];
    const double ligament = start.is_straight ? start.ligament : line.ligament;
    CrackWay way{chord.origin,
                 spacing,
                 std::max(speed_window_share * ligament, speed_window_spacings * spacing),
                 {},
                 opened_by(surface, facets, line, path, steps, first)};
    for (std::size_t i = 0; i < times.size(); ++i)
      way.points.push_back({first + path.arc_lengths()[i], times[i], reached[i]});
    ways.push_back(std::move(way));
  }
  return ways;
}

}  // namespace crackle::analysis
