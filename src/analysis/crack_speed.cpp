// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"

#include "crossings.h"

#include <algorithm>
#include <cmath>

namespace crackle::analysis {

namespace {

/// A crack front's mean position over the thickness, each time it moved; times strictly ascending.
struct FrontPosition {
  double time;     ///< [s]
  double advance;  ///< from the notch's tip [m]
};

/// The first entry is the front at the start of the dynamic phase.
/// @param reach what opens farther than this ahead of the front opened on its own: the front grows to it
/// later
std::vector<FrontPosition> front_history(const CrackSurface& surface, std::span<const std::size_t> facets,
                                         const NotchFrame& frame, double spacing, double thickness,
                                         double reach) {
  const auto n_columns = std::max<std::size_t>(1, static_cast<std::size_t>(thickness / (2 * spacing)));
  std::vector<double> farthest(n_columns, 0.0);
  std::vector<FrontPosition> history{{0, 0}};
  for (const std::size_t i : facets) {  // in order of breaking, hence of time
    const CrackFacet& facet = surface.facets[i];
    const Trace box = extent(surface, i, frame.across);
    double advance = 0;
    for (const geometry::Point& corner : facet.corner) {
      advance += frame.advance(corner[static_cast<std::size_t>(frame.axis)]) / 4;
    }
    if (facet.time > 0 && advance > history.back().advance + reach) continue;
    const auto column_of = [&](double x) {
      const double column = std::floor(x / thickness * static_cast<double>(n_columns));
      return static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(n_columns - 1)));
    };
    const std::size_t last = column_of(box.x[1]);
    for (std::size_t c = column_of(box.x[0]); c <= last; ++c) farthest[c] = std::max(farthest[c], advance);
    double mean = 0;
    for (const double value : farthest) mean += value / static_cast<double>(n_columns);
    if (mean <= history.back().advance) continue;
    if (facet.time > history.back().time) history.push_back({facet.time, mean});
    history.back().advance = mean;
  }
  return history;
}

/// The time at which a front passes a position between its first and its last.
double passing_time(const std::vector<FrontPosition>& front, double advance) {
  std::size_t k = 1;
  while (k + 1 < front.size() && front[k].advance < advance) ++k;
  const double share = (advance - front[k - 1].advance) / (front[k].advance - front[k - 1].advance);
  return front[k - 1].time + share * (front[k].time - front[k - 1].time);
}

}  // namespace

double max_crack_speed(const geometry::Body& body, const CrackSurface& surface) {
  double largest = 0;
  for (int notch = 0; notch < body.n_notches(); ++notch) {
    const std::vector<std::size_t> facets = facets_of_notch(surface, notch);
    if (facets.empty()) continue;
    const NotchFrame frame = notch_frame(body, notch);
    const double spacing = mean_spacing(surface, facets);
    const double window = std::max(speed_window_share * frame.ligament, speed_window_spacings * spacing);
    const std::vector<FrontPosition> front =
        front_history(surface, facets, frame, spacing, body.size()[0], window);
    // The time over a window is piecewise linear in its position: its least value is at one of the front's
    // recorded positions, at the window's start or at its end.
    const double first = front.front().advance;
    const double last = front.back().advance;
    if (last - first < window) continue;
    for (const FrontPosition& position : front) {
      for (const double start : {position.advance, position.advance - window}) {
        if (start < first || start + window > last) continue;
        const double time = passing_time(front, start + window) - passing_time(front, start);
        largest = std::max(largest, window / time);
      }
    }
  }
  return largest;
}

}  // namespace crackle::analysis
