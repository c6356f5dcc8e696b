// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample_arms.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"
#include "crackle/cracks/crack_line.h"
#include "crackle/cracks/crack_pattern.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace crackle::experiment {

namespace {

using plane::Point;

/// Arms are drawn out by this, in mean distances of their points, which are those of slabs.
constexpr double drawn_out_slabs = 1.5;
/// Lines that begin within this distance begin at one place [slabs].
constexpr double same_root_slabs = 3;
/// Pieces into which an arm is cut to measure how much of it is in a box.
constexpr int n_pieces = 100;

double slab_of(const TimedLine& arm) {
  return length_of(arm.points) / static_cast<double>(arm.points.size() - 1);
}

/// The line of a crack, turned by a symmetry if that is given.
TimedLine timed(const cracks::CrackLine& line, const geometry::Symmetry* symmetry) {
  TimedLine arm{.points = {}, .time = {}, .is_turned = symmetry != nullptr};
  for (const cracks::LinePoint& p : line.points) {
    const Point at{p.y, p.z};
    arm.points.push_back(symmetry == nullptr ? at : image_of(*symmetry, at));
    arm.time.push_back(p.time);
  }
  return arm;
}

bool is_main_line(const cracks::CrackLine& line, int start) {
  return line.start == start && line.parent < 0 && line.points.size() >= 2;
}

/// One arm through the root of two.
TimedLine joined(const TimedLine& one, const TimedLine& other) {
  TimedLine arm = one;
  std::ranges::reverse(arm.points);
  std::ranges::reverse(arm.time);
  arm.points.insert(arm.points.end(), other.points.begin(), other.points.end());
  arm.time.insert(arm.time.end(), other.time.begin(), other.time.end());
  return arm;
}

double length_within(const Polyline& line, const plane::Bounds& box) {
  const double length = length_of(line);
  int n_inside = 0;
  for (int i = 0; i < n_pieces; ++i) {
    const Point p = point_at(line, length * (i + 0.5) / n_pieces);
    const bool is_inside =
        p[0] >= box.lower[0] && p[0] <= box.upper[0] && p[1] >= box.lower[1] && p[1] <= box.upper[1];
    n_inside += is_inside ? 1 : 0;
  }
  return length * n_inside / n_pieces;
}

}  // namespace

const geometry::Symmetry* symmetry_to(const std::vector<geometry::Symmetry>& symmetries, int from, int to) {
  const auto found = std::ranges::find_if(
      symmetries, [&](const geometry::Symmetry& each) { return each.crack_start[index(from)] == to; });
  return found == symmetries.end() ? nullptr : &*found;
}

Point image_of(const geometry::Symmetry& symmetry, const Point& p) {
  const geometry::Point image = symmetry.image({0, p[0], p[1]});
  return {image[1], image[2]};
}

void add_arms(const geometry::Body& body, const std::vector<geometry::Symmetry>& symmetries,
              const cracks::CrackSurface& surface, ObservedSample& sample) {
  const auto lines = cracks::crack_lines(body, surface, cracks::find_branches(body, surface));
  const int leading = sample.summary.leading_start;
  const auto& starts = body.crack_starts();
  sample.arms.assign(starts.size(), {});
  for (int s = 0; s < std::ssize(starts); ++s) {
    auto& arms = sample.arms[index(s)];
    const geometry::Symmetry* symmetry = nullptr;
    int from = s;
    if (starts[index(s)].is_straight && leading >= 0 && leading != s) {
      symmetry = symmetry_to(symmetries, leading, s);
      if (symmetry != nullptr) from = leading;
    }
    for (const cracks::CrackLine& line : lines)
      if (is_main_line(line, from)) arms.push_back(timed(line, symmetry));
    if (arms.size() == 2 && plane::norm(arms[0].points[0] - arms[1].points[0]) <=
                                same_root_slabs * (slab_of(arms[0]) + slab_of(arms[1])) / 2)
      arms.push_back(joined(arms[0], arms[1]));
  }
}

const TimedLine* arm_in_sight(const ObservedSample& sample, int start, const plane::Bounds& box) {
  if (start < 0 || index(start) >= sample.arms.size() || sample.arms[index(start)].empty()) return nullptr;
  const auto& arms = sample.arms[index(start)];
  plane::Bounds wide = box;
  const double margin = plane::norm(box.upper - box.lower) / 2;
  for (std::size_t i = 0; i < 2; ++i) {
    wide.lower[i] -= margin;
    wide.upper[i] += margin;
  }
  return &*std::ranges::max_element(arms, {},
                                    [&](const TimedLine& arm) { return length_within(arm.points, wide); });
}

double drawn_out_by(const TimedLine& arm) {
  return drawn_out_slabs * slab_of(arm);
}

double arrival_at(const TimedLine& arm, const Point& place) {
  const double margin = drawn_out_by(arm);
  const Projection nearest = project(extended(arm.points, margin), place);
  const double length = length_of(arm.points);
  // At the very end of what was drawn out: the place lies farther ahead.
  if (nearest.at >= length + 2 * margin * (1 - 1e-9)) return not_a_number;
  const double at = std::clamp(nearest.at - margin, 0.0, length);
  // Facets opened in earlier phases are there at the start.
  const auto time = [&](std::size_t i) { return std::max(0.0, arm.time[i]); };
  double way = 0;
  for (std::size_t i = 1; i < arm.points.size(); ++i) {
    const double step = plane::norm(arm.points[i] - arm.points[i - 1]);
    if (way + step >= at && step > 0) return time(i - 1) + (at - way) / step * (time(i) - time(i - 1));
    way += step;
  }
  return time(arm.time.size() - 1);
}

}  // namespace crackle::experiment
