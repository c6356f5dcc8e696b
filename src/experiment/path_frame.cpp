// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/experiment/path_frame.h"

#include "crackle/common/real.h"

#include <algorithm>
#include <cmath>

namespace crackle::experiment {

namespace {

using plane::Point;

/// Points at which curves are compared to find the medoid.
constexpr std::size_t n_coarse_points = 21;
/// The medoid is among curves of at least this share of the median length.
constexpr double usual_share = 0.9;
/// Normals are those of chords over this share of the curve.
constexpr double chord_share = 0.1;
/// A path runs along a curve if what lies beside it is at least this share of its own length.
constexpr double least_share_along = 0.5;
/// Steps of a reading error per correlation length, and most of them along a path.
constexpr double steps_per_correlation = 2;
constexpr double max_steps = 1000;

Point unit(const Point& p) {
  const double length = plane::norm(p);
  return length > 0 ? (1 / length) * p : Point{0, 0};
}

Point left_of(const Point& p) {
  return {-p[1], p[0]};
}

Polyline resampled(const Polyline& line, std::size_t n) {
  const double length = length_of(line);
  Polyline points;
  for (std::size_t i = 0; i < n; ++i)
    points.push_back(point_at(line, length * static_cast<double>(i) / static_cast<double>(n - 1)));
  return points;
}

/// Mean distance of the points of one curve to another curve.
double mean_gap(const Polyline& one, const Polyline& other) {
  double sum = 0;
  for (const Point& p : one) sum += project(other, p).distance;
  return sum / static_cast<double>(one.size());
}

const Polyline& medoid_of(std::span<const Polyline> curves) {
  std::vector<Polyline> coarse;
  std::vector<double> lengths;
  for (const Polyline& curve : curves) {
    coarse.push_back(resampled(curve, n_coarse_points));
    lengths.push_back(length_of(curve));
  }
  std::vector<double> sums(curves.size(), 0);
  for (std::size_t i = 0; i < curves.size(); ++i) {
    for (std::size_t k = i + 1; k < curves.size(); ++k) {
      const double gap = mean_gap(coarse[i], coarse[k]) + mean_gap(coarse[k], coarse[i]);
      sums[i] += gap;
      sums[k] += gap;
    }
  }
  std::vector<double> sorted = lengths;
  std::ranges::nth_element(sorted, sorted.begin() + std::ssize(sorted) / 2);
  const double usual = usual_share * sorted[sorted.size() / 2];
  std::size_t best = curves.size();
  for (std::size_t i = 0; i < curves.size(); ++i)
    if (lengths[i] >= usual && (best == curves.size() || sums[i] < sums[best])) best = i;
  return curves[best];
}

}  // namespace

double length_of(const Polyline& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += plane::norm(line[i] - line[i - 1]);
  return length;
}

Projection project(const Polyline& line, const Point& p) {
  Projection nearest{0, infinity};
  double way = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Point side = line[i] - line[i - 1];
    const double length = plane::norm(side);
    const double along = length > 0 ? std::clamp(plane::dot(p - line[i - 1], side) / length, 0.0, length) : 0;
    const Point foot = line[i - 1] + (length > 0 ? along / length : 0) * side;
    const double distance = plane::norm(p - foot);
    if (distance < nearest.distance) nearest = {way + along, distance};
    way += length;
  }
  return nearest;
}

Point point_at(const Polyline& line, double arc_length) {
  double way = 0;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Point side = line[i] - line[i - 1];
    const double length = plane::norm(side);
    if (way + length >= arc_length && length > 0)
      return line[i - 1] + (std::max(0.0, arc_length - way) / length) * side;
    way += length;
  }
  return line.back();
}

Polyline extended(const Polyline& line, double length) {
  Polyline longer = line;
  const std::size_t n = line.size();
  longer.insert(longer.begin(), line[0] + length * unit(line[0] - line[1]));
  longer.push_back(line[n - 1] + length * unit(line[n - 1] - line[n - 2]));
  return longer;
}

Polyline with_reading_error(const Polyline& line, double deviation, double correlation_length,
                            RandomStream stream) {
  if (!(deviation > 0)) return line;
  const double length = length_of(line);
  const double wanted = correlation_length > 0 ? steps_per_correlation * length / correlation_length : 0;
  const auto n_steps = static_cast<std::size_t>(
      std::clamp(std::ceil(wanted), static_cast<double>(n_coarse_points), max_steps));
  const double step = length / static_cast<double>(n_steps);
  const double memory = correlation_length > 0 ? std::exp(-step / correlation_length) : 0;
  Polyline read;
  double error = deviation * stream.normal();
  for (std::size_t i = 0; i <= n_steps; ++i) {
    const double at = step * static_cast<double>(i);
    const Point chord =
        point_at(line, std::min(at + step, length)) - point_at(line, std::max(at - step, 0.0));
    read.push_back(point_at(line, at) + error * left_of(unit(chord)));
    error = memory * error + deviation * std::sqrt(1 - memory * memory) * stream.normal();
  }
  return read;
}

std::optional<PathFrame> path_frame(std::span<const Polyline> curves, std::span<const Window> windows) {
  const Polyline& medoid = medoid_of(curves);
  const double length = length_of(medoid);
  double from = 0, to = length;
  for (const Window& window : windows) {
    if (!runs_along(medoid, window.first, window.last)) continue;
    const double first = project(medoid, window.first).at, last = project(medoid, window.last).at;
    const bool ascends = first <= last;
    from = std::max(from, ascends ? first : window.is_arrested ? 0 : last);
    to = std::min(to, !ascends ? first : window.is_arrested ? length : last);
  }
  if (!(to > from)) return std::nullopt;
  PathFrame frame;
  frame.curve = medoid;
  Point sum{0, 0};
  for (std::size_t i = 0; i < n_stations; ++i) {
    const double at = from + (to - from) * (static_cast<double>(i) + 0.5) / n_stations;
    const double half = chord_share * length / 2;
    const Point chord =
        point_at(medoid, std::min(at + half, length)) - point_at(medoid, std::max(at - half, 0.0));
    frame.place.push_back(point_at(medoid, at));
    frame.normal.push_back(left_of(unit(chord)));
    sum = sum + frame.normal.back();
  }
  frame.is_along_y = std::abs(sum[0]) >= std::abs(sum[1]);
  if (sum[frame.is_along_y ? 0 : 1] < 0)
    for (Point& each : frame.normal) each = -1.0 * each;
  return frame;
}

bool runs_along(const Polyline& curve, const Point& first, const Point& last) {
  const double beside = std::abs(project(curve, last).at - project(curve, first).at);
  return beside >= least_share_along * std::min(plane::norm(last - first), length_of(curve));
}

std::vector<double> offsets(const PathFrame& frame, const Polyline& curve) {
  if (curve.empty() || !runs_along(frame.curve, curve.front(), curve.back()))
    return std::vector<double>(frame.place.size(), not_a_number);
  const double reach = length_of(frame.curve);
  std::vector<double> found;
  for (std::size_t k = 0; k < frame.place.size(); ++k) {
    const Point& n = frame.normal[k];
    const Point along = left_of(n);
    double nearest = infinity;
    for (std::size_t i = 1; i < curve.size(); ++i) {
      const Point a = curve[i - 1] - frame.place[k], b = curve[i] - frame.place[k];
      const double before = plane::dot(a, along), after = plane::dot(b, along);
      if ((before < 0) == (after < 0)) continue;
      const double share = before / (before - after);
      const double offset = (1 - share) * plane::dot(a, n) + share * plane::dot(b, n);
      if (std::abs(offset) < std::abs(nearest)) nearest = offset;
    }
    found.push_back(std::abs(nearest) <= reach ? nearest : not_a_number);
  }
  return found;
}

}  // namespace crackle::experiment
