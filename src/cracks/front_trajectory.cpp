// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/front_trajectory.h"

#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "cracks/branching.h"
#include "cracks/crack_ligaments.h"

#include "crack_graph.h"
#include "polyline.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <tuple>
#include <utility>

namespace crackle::cracks {

namespace {

/// A chain's steps from one branch to another beside it.
class SideSteps {
public:
  /// Takes the steps out of the path: what is left of each is as long as a crack can run meanwhile.
  /// @param reached when the crack had opened at each place or farther on [s]
  /// @param slowness of Rayleigh waves at each place [s/m]
  SideSteps(std::vector<Polyline::Place>& path, const std::vector<double>& reached,
            const std::vector<double>& slowness, double spacing) {
    Polyline::Place last = path.front(), out{0, 0};
    for (std::size_t i = 1; i < path.size();) {
      // To the next place at which the crack was before it was farther on.
      std::size_t next = i;
      while (next + 1 < path.size() && reached[next + 1] == reached[i]) ++next;
      const Polyline::Place here = path[next];
      const double ahead = here.advance - last.advance, step = here.across - last.across;
      const auto from = slowness.begin() + static_cast<std::ptrdiff_t>(i - 1);
      const double least = *std::min_element(from, from + static_cast<std::ptrdiff_t>(next + 2 - i));
      const double run = (reached[next] - reached[i - 1]) / least;
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
std::vector<FrontTrajectory::Opened> opened_by(const CrackSurface& surface,
                                               std::span<const std::size_t> facets,
                                               const geometry::CrackStart& line, const Polyline& path,
                                               const SideSteps& steps, double first) {
  std::vector<FrontTrajectory::Opened> all;
  for (std::size_t i = 0; i < facets.size();) {
    const CrackFacet& facet = surface.facets[facets[i]];
    FrontTrajectory::Opened opened{facet.time, 0, {infinity, -infinity}};
    geometry::Point sum{};
    double n = 0;
    for (; i < facets.size(); ++i) {
      const CrackFacet& other = surface.facets[facets[i]];
      if (other.tetrahedron != facet.tetrahedron || other.time != facet.time) break;
      for (const geometry::Point& corner : other.corner) {
        sum = sum + corner;
        opened.x[0] = std::min(opened.x[0], Projection::depth(corner));
        opened.x[1] = std::max(opened.x[1], Projection::depth(corner));
        n += 1;
      }
    }
    const geometry::Point middle = sum / n;
    opened.place = first + path.foot(steps.without({line.advance(middle), dot(middle, line.across)}));
    all.push_back(opened);
  }
  std::ranges::sort(all, {}, [](const FrontTrajectory::Opened& o) { return std::tie(o.time, o.place, o.x); });
  return all;
}

/// Adds when the front comes to the points of a path, and its runs between jumps.
/// @param places along the chain before it is smoothed [m]
void follow_front(std::vector<FrontTrajectory::Point>& points, const std::vector<double>& places,
                  double reach) {
  std::vector<double> come;  // when the front comes to each point itself
  int run = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double before = i == 0 ? -infinity : come[i - 1];
    for (std::size_t k = i; k-- > 0 && places[i] - places[k] <= reach;) before = std::min(before, come[k]);
    const bool has_opened_before = points[i].time < before;
    if (i > 0 && (has_opened_before || places[i] - places[i - 1] > reach)) ++run;
    points[i].run = has_opened_before ? -1 : run;
    come.push_back(std::max(points[i].time, before));
  }
  double reached = infinity;
  for (std::size_t i = points.size(); i-- > 0;) points[i].reached = reached = std::min(reached, come[i]);
}

/// The line through the arrivals at some points in the last dynamic phase, over their places from an origin.
LineFit fit_arrivals(std::span<const FrontTrajectory::Point> points, double origin) {
  LineFit arrival;
  for (const FrontTrajectory::Point& point : points)
    if (point.reached > 0) arrival.add(point.place - origin, point.time);
  return arrival;
}

/// Makes jumps of the windows that the front passes faster than a Rayleigh wave.
void add_jumps(FrontTrajectory& front) {
  std::vector<FrontTrajectory::Point>& points = front.points;
  std::vector<char> is_jump(points.size(), 0);
  for (auto first = points.begin(); first != points.end(); ++first) {
    const auto end = std::ranges::find_if(first, points.end(), [&](const auto& point) {
      return point.run != first->run || point.place > first->place + front.window;
    });
    const LineFit arrival = fit_arrivals({first, end}, first->place);
    if (arrival.n() > 2 && arrival.slope() < front.slowness(first->place, std::prev(end)->place))
      std::fill_n(is_jump.begin() + (first - points.begin()), end - first, 1);
  }
  int n_ends = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && is_jump[i] != is_jump[i - 1]) ++n_ends;
    points[i].run = is_jump[i] != 0 || points[i].run < 0 ? -1 : points[i].run + n_ends;
  }
}

}  // namespace

double FrontTrajectory::slowness(double from, double to) const {
  const double usual = points.front().slowness;
  const auto delay_until = [&](double place) {
    const auto next = std::ranges::upper_bound(points, place, {}, &Point::place);
    if (next == points.begin()) return 0.0;
    const Point& last = *std::prev(next);
    const double ahead = place - last.place;
    const double here = next == points.end()
                            ? last.slowness
                            : std::lerp(last.slowness, next->slowness, ahead / (next->place - last.place));
    return last.delay + ahead * ((last.slowness + here) / 2 - usual);
  };
  return usual + (delay_until(to) - delay_until(from)) / (to - from);
}

double FrontTrajectory::mean_time(double from, double to) const {
  const auto first = std::ranges::lower_bound(points, from, {}, &Point::place);
  const auto end = std::ranges::upper_bound(first, points.end(), to, {}, &Point::place);
  const LineFit arrival = fit_arrivals({first, end}, from);
  return arrival.n() > 2 ? arrival.slope() * (to - from) : 0;
}

std::vector<FrontTrajectory> front_trajectories(const geometry::Body& body, const CrackSurface& surface,
                                                const mechanics::TetrahedronField<double>& rayleigh_speed) {
  std::vector<FrontTrajectory> trajectories;
  const Projection projection(body);
  std::vector<CrackLigament> chords = crack_ligaments(body, surface, Followed::chords);
  const CrackBranches branches = find_branches(body, surface, chords);
  for (CrackLigament& chord : chords) {
    std::erase_if(chord.facets, [&](std::size_t i) { return branches.branch[i] > 0; });
    const geometry::CrackStart& line = chord.line;
    const double spacing = mean_spacing(surface, chord.facets);
    std::vector<Polyline::Place> places;
    std::vector<double> times, slowness;
    Indices facets;
    for (const PathLink& link :
         CrackGraph(projection, surface, chord.facets, line, spacing).longest_path(false)) {
      facets.insert(facets.end(), link.facets.begin(), link.facets.end());
      const double advance = (static_cast<double>(link.level) + 0.5) * spacing;
      const auto crossing =
          main_crossing(intersect(surface, link.facets, line.plane_at(advance)), projection.thickness());
      if (!crossing) continue;  // the rough edges of a piece can leave gaps
      places.push_back({advance, crossing->mean});
      times.push_back(crossing->arrival);
      slowness.push_back(mean_slowness(surface, link.facets, rayleigh_speed));
    }
    if (places.size() < 2) continue;
    sort_unique(facets);
    std::vector<double> reached = times;
    for (std::size_t i = reached.size() - 1; i-- > 0;) reached[i] = std::min(reached[i], reached[i + 1]);
    const SideSteps steps(places, reached, slowness, spacing);
    const std::vector<double> unsmoothed = Polyline(places).arc_lengths();
    const Polyline path = Polyline(std::move(places)).smoothed(path_smoothing * spacing);
    const double first = std::hypot(path.front().advance, path.front().across - dot(line.tip, line.across));
    const geometry::CrackStart& start = body.crack_starts()[index(chord.origin)];
    const double ligament = start.is_straight ? start.ligament : line.ligament;
    FrontTrajectory found{chord.origin,
                          spacing,
                          std::max(speed_window_share * ligament, speed_window_spacings * spacing),
                          {},
                          opened_by(surface, facets, line, path, steps, first)};
    for (std::size_t i = 0; i < times.size(); ++i) {
      FrontTrajectory::Point point{first + path.arc_lengths()[i], times[i], 0, 0, slowness[i], 0};
      if (i > 0)
        point.delay = found.points.back().delay + (point.place - found.points.back().place) *
                                                      ((slowness[i - 1] + slowness[i]) / 2 - slowness[0]);
      found.points.push_back(point);
    }
    follow_front(found.points, unsmoothed, front_reach * spacing);
    add_jumps(found);
    trajectories.push_back(std::move(found));
  }
  return trajectories;
}

}  // namespace crackle::cracks
