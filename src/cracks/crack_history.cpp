// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/crack_history.h"

#include "common/index.h"

#include "polyline.h"
#include "projection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

namespace crackle::cracks {

namespace {

/// The energy released by the cracks that began at a start over time.
class Releases {
public:
  /// @pre times ascend
  void add(double time, double energy) {
    times_.push_back(time);
    sums_.push_back((sums_.empty() ? 0 : sums_.back()) + energy);
  }
  double until(double time) const {
    const auto n = std::ranges::upper_bound(times_, time) - times_.begin();
    return n > 0 ? sums_[index(n - 1)] : 0;
  }

private:
  std::vector<double> times_, sums_;  // [s], [J]
};

/// The point that a front comes to next.
auto next_point(const FrontTrajectory& front, double time) {
  return std::ranges::upper_bound(front.points, time, {}, &FrontTrajectory::Point::reached);
}

/// Position of a front's tip at a time.
double place_at(const FrontTrajectory& front, double time) {
  const auto next = next_point(front, time);
  if (next == front.points.begin()) return 0;
  if (next == front.points.end()) return front.length();
  const FrontTrajectory::Point& last = *std::prev(next);
  return std::lerp(last.place, next->place, (time - last.reached) / (next->reached - last.reached));
}

struct Tip {
  double speed = not_a_number;
  double speed_ratio = not_a_number;   ///< to the Rayleigh speed there
  double release_rate = not_a_number;  ///< per length of its path [J/m]
};

/// A front's tip at a time of the dynamic phase while it is moving, by straight lines fitted over the part of
/// the window around it that it passed in that phase, up to its jumps.
Tip tip_at(const FrontTrajectory& front, double time, const Releases& releases) {
  LineFit arrival, energy;
  if (front.points.empty() || time <= std::max(0.0, front.points.front().reached) ||
      time >= front.points.back().reached)
    return {};
  const double place = place_at(front, time);
  const int run = next_point(front, time)->run;
  if (run < 0) return {};
  double first = infinity, last = 0;
  for (const FrontTrajectory::Point& point : front.points) {
    const double ahead = point.place - place;
    if (std::abs(ahead) > front.window / 2 || point.reached <= 0 || point.run != run) continue;
    arrival.add(ahead, point.time);
    energy.add(ahead, releases.until(point.reached));
    first = std::min(first, point.place);
    last = point.place;
  }
  if (arrival.n() <= 2 || !(arrival.slope() > 0)) return {};
  const double speed = 1 / arrival.slope(), ratio = speed * front.slowness(first, last);
  if (ratio > 1) return {};  // no crack outruns a Rayleigh wave
  return {speed, ratio, energy.slope()};
}

/// The front of a crack that is too short for a path: how far its facets lie from the start; without speeds.
FrontTrajectory short_front(const CrackSurface& surface, const geometry::CrackStart& start,
                            std::int32_t number) {
  FrontTrajectory front{};
  for (const CrackFacet& facet : surface.facets) {
    if (surface.cracks[index(facet.crack)].origin() != number) continue;
    double place = 0;
    for (const geometry::Point& corner : facet.corner) place += start.advance(corner) / 4;
    if (place <= front.length()) continue;
    if (!front.points.empty() && facet.time <= front.points.back().reached)
      front.points.back().place = place;
    else
      front.points.push_back({place, facet.time, facet.time, 0, not_a_number, 0});
  }
  return front;
}

/// The front on the longest path of each crack start.
std::vector<FrontTrajectory> longest_fronts(const geometry::Body& body, const CrackSurface& surface,
                                            std::span<const FrontTrajectory> trajectories) {
  const auto& starts = body.crack_starts();
  std::vector<FrontTrajectory> longest(starts.size());
  for (const FrontTrajectory& one : trajectories)
    if (one.length() > longest[index(one.start)].length()) longest[index(one.start)] = one;
  for (std::size_t k = 0; k < starts.size(); ++k)
    if (longest[k].points.empty()) longest[k] = short_front(surface, starts[k], static_cast<std::int32_t>(k));
  return longest;
}

/// Energy released by the tetrahedra of each start's cracks, in order of breaking. A facet's time is that of
/// its tetrahedron.
std::vector<Releases> releases_of(const CrackSurface& surface, std::size_t n_starts,
                                  const dynamics::SampleResult& result) {
  std::map<std::int64_t, double> energy;
  const auto add = [&](const auto& records) {
    for (const auto& record : records) energy[record.tetrahedron] += record.released_energy;
  };
  add(result.breaks);
  add(result.bridge_releases);
  add(result.stiffness_reductions);
  std::vector<Releases> releases(n_starts);
  for (const CrackFacet& facet : surface.facets) {
    const auto found = energy.find(facet.tetrahedron);
    const auto origin = surface.cracks[index(facet.crack)].origin();
    if (found == energy.end() || origin < 0) continue;
    releases[index(origin)].add(facet.time, found->second);
    energy.erase(found);
  }
  return releases;
}

/// How far a crack reaches from its first facet.
class Reach {
public:
  void add(const CrackFacet& facet) {
    geometry::Point middle{};
    for (const geometry::Point& corner : facet.corner) middle = middle + corner / 4;
    if (steps_.empty()) {
      first_ = middle;
      steps_.push_back({0, facet.time});
    }
    const double reach = norm(middle - first_);
    if (reach > steps_.back().reach) steps_.push_back({reach, facet.time});
    spacing_ += local_spacing(facet);
    ++n_;
  }
  /// @pre in the order of breaking
  double at(double time) const {
    const auto next = std::ranges::upper_bound(steps_, time, {}, &Step::time);
    return next == steps_.begin() ? 0 : std::prev(next)->reach;
  }
  /// NaN before and after it grows.
  double speed_at(double time) const {
    if (steps_.empty() || time < std::max(0.0, steps_.front().time) || time >= steps_.back().time)
      return not_a_number;
    const double place = at(time), window = speed_window_spacings * spacing_ / n_;
    LineFit arrival;
    for (const Step& step : steps_)
      if (step.time > 0 && std::abs(step.reach - place) <= window) arrival.add(step.reach, step.time);
    const bool is_known = arrival.n() > 2 && arrival.variance() > 0 && arrival.slope() > 0;
    return is_known ? 1 / arrival.slope() : not_a_number;
  }

private:
  struct Step {
    double reach, time;
  };
  std::vector<Step> steps_;
  geometry::Point first_{};
  double spacing_ = 0;
  int n_ = 0;
};

}  // namespace

CracksInSpace cracks_in_space(const CrackSurface& surface, std::span<const std::size_t> n_open,
                              std::span<const double> time, double rayleigh_speed) {
  const std::size_t n_cracks = surface.cracks.size();
  std::vector<Reach> reach(n_cracks);
  for (const CrackFacet& facet : surface.facets) reach[index(facet.crack)].add(facet);
  CracksInSpace found;
  std::vector<double> area(n_cracks, 0.0);
  std::size_t facet = 0;
  for (std::size_t moment = 0; moment < n_open.size(); ++moment) {
    for (; facet < n_open[moment]; ++facet)
      area[index(surface.facets[facet].crack)] += surface.facets[facet].area;
    for (std::size_t k = 0; k < n_cracks; ++k) {
      found.area.push_back(area[k]);
      found.reach.push_back(area[k] > 0 ? reach[k].at(time[moment]) : 0);
      const double speed = reach[k].speed_at(time[moment]);
      found.speed.push_back(speed > rayleigh_speed ? not_a_number : speed);
    }
  }
  return found;
}

CrackHistory crack_history(const geometry::Body& body, const CrackSurface& surface,
                           const dynamics::SampleResult& result,
                           std::span<const FrontTrajectory> trajectories,
                           const mechanics::TetrahedronField<double>& rayleigh_speed) {
  CrackHistory history;
  std::vector<std::size_t> all(surface.facets.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  history.rayleigh_speed = 1 / mean_slowness(surface, all, rayleigh_speed);
  const std::size_t n_starts = history.n_starts = body.crack_starts().size();
  const std::vector<FrontTrajectory> fronts = longest_fronts(body, surface, trajectories);
  const auto releases = releases_of(surface, n_starts, result);
  std::vector<double> area(n_starts, 0.0);  // by the start where the crack began
  std::vector<std::size_t> belongs_to(n_starts);
  std::iota(belongs_to.begin(), belongs_to.end(), 0);
  for (const Crack& crack : surface.cracks)
    if (crack.hole >= 0) belongs_to[index(crack.hole)] = index(crack.start);
  const double start = start_of_times(result.breaks, result.phase_start);
  const bool is_plate = !body.outline().empty();
  std::vector<std::size_t> n_facets;  // that are open at each moment
  std::vector<double> times;
  std::size_t facet = 0, n_open = 0;
  for (const dynamics::HistoryRow& row : result.history) {
    // Facets are in order of breaking, several per tetrahedron.
    for (; facet < surface.facets.size(); ++facet) {
      const bool is_next =
          facet == 0 || surface.facets[facet].tetrahedron != surface.facets[facet - 1].tetrahedron;
      if (is_next && n_open == index(row.energy.broken)) break;
      if (is_next) ++n_open;
      const auto origin = surface.cracks[index(surface.facets[facet].crack)].origin();
      if (origin >= 0) area[index(origin)] += surface.facets[facet].area;
    }
    const bool is_dynamic = row.phase > 0 && row.phase == result.counts.dynamic_phases;
    // On the time axis of the facets.
    const double time = is_dynamic ? row.energy.time : row.load_time - start;
    n_facets.push_back(facet);
    times.push_back(time);
    for (std::size_t k = 0; k < n_starts; ++k) {
      double all_area = 0, length = 0;
      Tip tip;
      for (std::size_t from = 0; from < n_starts; ++from) {
        if (belongs_to[from] != k) continue;
        all_area += area[from];
        if (!is_plate) continue;
        if (area[from] > 0) length += place_at(fronts[from], time);
        const Tip here = is_dynamic ? tip_at(fronts[from], time, releases[from]) : Tip{};
        if (here.speed > tip.speed || std::isnan(tip.speed)) tip = here;
      }
      history.area.push_back(all_area);
      history.length.push_back(is_plate ? length : not_a_number);
      history.speed.push_back(tip.speed);
      history.speed_ratio.push_back(tip.speed_ratio);
      history.release_rate.push_back(tip.release_rate / Projection(body).thickness());
    }
  }
  if (!is_plate) history.in_space = cracks_in_space(surface, n_facets, times, history.rayleigh_speed);
  return history;
}

}  // namespace crackle::cracks
