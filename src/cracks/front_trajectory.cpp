// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/cracks/front_trajectory.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/common/vector.h"
#include "crackle/cracks/branching.h"
#include "crackle/cracks/crack_ligaments.h"

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

/// A step to the side is one from branch to branch if it is longer than this [spacings], and this many times
/// as fast as the crack usually advances.
constexpr double least_side_step = 1, side_step_speed = 1.5;

Polyline::Place operator-(const Polyline::Place& a, const Polyline::Place& b) {
  return {a.advance - b.advance, a.across - b.across};
}

/// A path's steps from one branch to another beside it.
class SideSteps {
public:
  /// Takes the steps out of the path: what is left of each is as long as the crack runs meanwhile.
  /// @param reached when the crack had opened at each place or farther on [s]
  /// @param speed of the crack along the chord [m/s]
  SideSteps(std::vector<Polyline::Place>& path, const std::vector<double>& reached, double speed,
            double spacing) {
    Polyline::Place last = path.front(), out{0, 0};
    for (std::size_t i = 1; i < path.size();) {
      // To the next place at which the crack was before it was farther on.
      std::size_t next = i;
      while (next + 1 < path.size() && reached[next + 1] == reached[i]) ++next;
      const Polyline::Place here = path[next];
      const double ahead = here.advance - last.advance, step = here.across - last.across;
      const double run = (reached[next] - reached[i - 1]) * speed;
      if (std::abs(step) > least_side_step * spacing && std::hypot(ahead, step) > side_step_speed * run) {
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

/// Median speed along the chord.
double usual_speed(const std::vector<Polyline::Place>& path, const std::vector<double>& reached) {
  std::vector<double> speeds;
  for (std::size_t i = 1; i < path.size(); ++i)
    if (reached[i] > reached[i - 1])
      speeds.push_back((path[i].advance - path[i - 1].advance) / (reached[i] - reached[i - 1]));
  if (speeds.empty()) return infinity;
  const auto middle = speeds.begin() + static_cast<std::ptrdiff_t>(speeds.size() / 2);
  std::ranges::nth_element(speeds, middle);
  return *middle;
}

/// Adds when the front comes to the points of a path, and its runs between jumps.
void follow_front(std::vector<FrontTrajectory::Point>& points, double reach) {
  std::vector<double> come;  // when the front comes to each point itself
  int run = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    double before = i == 0 ? -infinity : come[i - 1];
    for (std::size_t k = i; k-- > 0 && points[i].place - points[k].place <= reach;)
      before = std::min(before, come[k]);
    const bool has_opened_before = points[i].time < before;
    if (i > 0 && (has_opened_before || points[i].place - points[i - 1].place > reach)) ++run;
    points[i].run = has_opened_before ? -1 : run;
    come.push_back(std::max(points[i].time, before));
  }
  double reached = infinity;
  for (std::size_t i = points.size(); i-- > 0;) points[i].reached = reached = std::min(reached, come[i]);
}

}  // namespace

double FrontTrajectory::slowness(double from, double to) const {
  const double usual = points.front().slowness;  // sums are of differences, which are 0 in one material
  double sum = 0, n = 0;
  for (const Point& point : points) {
    if (point.place < from || point.place > to) continue;
    sum += point.slowness - usual;
    n += 1;
  }
  return n > 0 ? usual + sum / n : usual;
}

std::vector<FrontTrajectory> front_trajectories(const geometry::Body& body, const CrackSurface& surface,
                                                const mechanics::TetrahedronField<double>& rayleigh_speed) {
  std::vector<FrontTrajectory> trajectories;
  const Projection projection(body);
  const std::vector<CrackLigament> chords = crack_ligaments(body, surface, Followed::chords);
  const CrackBranches branches = find_branches(body, surface, chords);
  for (const CrackLigament& chord : chords) {
    const geometry::CrackStart& line = chord.line;
    const geometry::CrackStart& start = body.crack_starts()[index(chord.origin)];
    const double ligament = start.is_straight ? start.ligament : line.ligament;
    for (const auto& [branch, own] : by_branch(chord.facets, branches)) {
      const double spacing = mean_spacing(surface, own);
      std::vector<Polyline::Place> places;
      std::vector<double> times, slowness;
      Indices facets;
      for (const PathLink& link : CrackGraph(projection, surface, own, line, spacing).longest_path(false)) {
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
      const SideSteps steps(places, reached, usual_speed(places, reached), spacing);
      const Polyline path = Polyline(std::move(places)).smoothed(path_smoothing * spacing);
      const double first =
          branch > 0 ? 0 : std::hypot(path.front().advance, path.front().across - dot(line.tip, line.across));
      FrontTrajectory found{
          chord.origin, branch > 0,
          spacing,      std::max(speed_window_share * ligament, speed_window_spacings * spacing),
          {},           opened_by(surface, facets, line, path, steps, first)};
      for (std::size_t i = 0; i < times.size(); ++i)
        found.points.push_back({first + path.arc_lengths()[i], times[i], 0, 0, slowness[i]});
      follow_front(found.points, front_reach * spacing);
      trajectories.push_back(std::move(found));
    }
  }
  return trajectories;
}

}  // namespace crackle::cracks
