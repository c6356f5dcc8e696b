// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_history.h"

#include "crackle/analysis/crack_path.h"
#include "crackle/common/index.h"
#include "crackle/common/real.h"

#include "crossings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <utility>

namespace crackle::analysis {

namespace {

/// The break of a tetrahedron, with the energy it has released.
struct Release {
  double time;
  double energy;  // [J]
};

/// The course of a tip along a crack line.
class TipCourse {
public:
  TipCourse() = default;
  /// @param first from the crack start to the line's first point [m]
  TipCourse(const CrackLine& line, double first, double spacing) {
    double length = first;
    for (std::size_t i = 0; i < line.points.size(); ++i) {
      const LinePoint& point = line.points[i];
      if (i > 0) length += std::hypot(point.y - line.points[i - 1].y, point.z - line.points[i - 1].z);
      place_.push_back(length);
      time_.push_back(point.time);
    }
    reached_ = time_;
    for (std::size_t i = reached_.size(); i-- > 1;) reached_[i - 1] = std::min(reached_[i - 1], reached_[i]);
    window_ = std::max(speed_window_share * (length - first), speed_window_spacings * spacing);
  }

  double length() const { return place_.empty() ? 0 : place_.back(); }

  /// Position of the tip at a time.
  double place_at(double time) const {
    if (place_.empty() || time < reached_.front()) return 0;
    const auto next = std::ranges::upper_bound(reached_, time) - reached_.begin();
    if (next == std::ssize(reached_)) return place_.back();
    const double start = reached_[index(next - 1)], end = reached_[index(next)];
    return std::lerp(place_[index(next - 1)], place_[index(next)], (time - start) / (end - start));
  }

  /// Time at which the tip reaches a position.
  double time_at(double place) const {
    const auto next = std::ranges::lower_bound(place_, place) - place_.begin();
    if (next == 0) return reached_.front();
    if (next == std::ssize(place_)) return reached_.back();
    const double share = (place - place_[index(next - 1)]) / (place_[index(next)] - place_[index(next - 1)]);
    return std::lerp(reached_[index(next - 1)], reached_[index(next)], share);
  }

  /// True if the tip is moving in the dynamic phase.
  bool runs_at(double time) const {
    return place_.size() > 1 && time > std::max(0.0, reached_.front()) && time < reached_.back();
  }

  /// The window around a position.
  std::pair<double, double> window_at(double place) const {
    return {std::max(0.0, place - window_ / 2), std::min(length(), place + window_ / 2)};
  }

  /// Speed over the part of the window that the tip passed in the dynamic phase.
  double speed_at(double place) const {
    const auto [from, to] = window_at(place);
    double n = 0, s = 0, t = 0, ss = 0, st = 0;
    for (std::size_t i = 0; i < place_.size(); ++i) {
      if (place_[i] < from || place_[i] > to || reached_[i] <= 0) continue;
      const double x = place_[i] - place, y = time_[i];
      n += 1;
      s += x;
      t += y;
      ss += x * x;
      st += x * y;
    }
    const double slowness = (n * st - s * t) / (n * ss - s * s);
    return n > 2 && slowness > 0 ? 1 / slowness : not_a_number;
  }

private:
  std::vector<double> place_;    // along the line [m]
  std::vector<double> time_;     // at which the crack opened there [s]
  std::vector<double> reached_;  // when it has opened there or farther on; ascending
  double window_ = 0;
};

/// The longest line of each crack start.
std::vector<TipCourse> tip_courses(const geometry::Body& body, const CrackSurface& surface,
                                   const std::vector<CrackLine>& lines) {
  std::vector<TipCourse> courses(body.crack_starts().size());
  for (const CrackLine& line : lines) {
    if (line.start < 0 || line.parent >= 0 || index(line.start) >= courses.size()) continue;
    const geometry::CrackStart& start = body.crack_starts()[index(line.start)];
    const double first = start.is_straight && !line.points.empty()
                             ? std::hypot(line.points[0].y - start.tip[1], line.points[0].z - start.tip[2])
                             : 0;
    TipCourse course(line, first, mean_spacing(surface, facets_from(surface, line.start)));
    TipCourse& longest = courses[index(line.start)];
    if (course.length() > longest.length()) longest = std::move(course);
  }
  return courses;
}

/// Energy released by the tetrahedra of each start's cracks, in order of breaking. A facet's time is that of
/// its tetrahedron.
std::vector<std::vector<Release>> releases_of(const CrackSurface& surface, std::size_t n_starts,
                                              const dynamics::SampleResult& result) {
  std::map<std::int64_t, double> energy;
  const auto add = [&](const auto& records) {
    for (const auto& record : records) energy[record.tetrahedron] += record.released_energy;
  };
  add(result.breaks);
  add(result.bridge_releases);
  add(result.stiffness_reductions);
  std::vector<std::vector<Release>> releases(n_starts);
  for (const CrackFacet& facet : surface.facets) {
    const auto found = energy.find(facet.tetrahedron);
    const auto origin = surface.cracks[index(facet.crack)].start;
    if (found == energy.end() || origin < 0) continue;
    releases[index(origin)].push_back({facet.time, found->second});
    energy.erase(found);
  }
  return releases;
}

double released_between(std::span<const Release> releases, double from, double to) {
  double sum = 0;
  for (const Release& release : releases)
    if (release.time > from && release.time <= to) sum += release.energy;
  return sum;
}

}  // namespace

CrackHistory crack_history(const geometry::Body& body, const CrackSurface& surface,
                           const std::vector<CrackLine>& lines, const dynamics::SampleResult& result) {
  CrackHistory history;
  const std::size_t n_starts = history.n_starts = body.crack_starts().size();
  const std::vector<TipCourse> courses = tip_courses(body, surface, lines);
  const auto releases = releases_of(surface, n_starts, result);
  std::vector<double> area(n_starts, 0.0);
  const double start = start_of_times(result.breaks, result.phase_start);
  std::size_t facet = 0, n_open = 0;
  for (const dynamics::HistoryRow& row : result.history) {
    // Facets are in order of breaking, several per tetrahedron.
    for (; facet < surface.facets.size(); ++facet) {
      const bool is_next =
          facet == 0 || surface.facets[facet].tetrahedron != surface.facets[facet - 1].tetrahedron;
      if (is_next && n_open == index(row.energy.broken)) break;
      if (is_next) ++n_open;
      const auto origin = surface.cracks[index(surface.facets[facet].crack)].start;
      if (origin >= 0) area[index(origin)] += surface.facets[facet].area;
    }
    const bool is_dynamic = row.phase > 0 && row.phase == result.counts.dynamic_phases;
    // On the time axis of the facets.
    const double time = is_dynamic ? row.energy.time : row.load_time - start;
    for (std::size_t k = 0; k < n_starts; ++k) {
      const TipCourse& course = courses[k];
      const double place = area[k] > 0 ? course.place_at(time) : 0;
      const bool runs = is_dynamic && course.runs_at(time);
      const auto [from, to] = course.window_at(place);
      history.area.push_back(area[k]);
      history.length.push_back(place);
      const double speed = runs ? course.speed_at(place) : not_a_number;
      history.speed.push_back(speed);
      history.release_rate.push_back(
          speed > 0 ? released_between(releases[k], course.time_at(from), course.time_at(to)) /
                          ((to - from) * body.size()[0])
                    : not_a_number);
    }
  }
  return history;
}

}  // namespace crackle::analysis
