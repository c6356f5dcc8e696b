// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/crack_path.h"

#include "crossings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace crackle::analysis {

namespace {

/// A crack front's mean position over the thickness, each time it moved; times strictly ascending.
struct FrontPosition {
  double time;     ///< [s]
  double advance;  ///< from the notch's tip [m]
};

/// A crack front on its way. What opens on its own, farther than `reach` ahead of it, counts from when the
/// front has come to it.
class Front {
public:
  Front(double thickness, double spacing, double reach)
      : gap_(spacing),
        farthest_(std::max<std::size_t>(1, static_cast<std::size_t>(thickness / (2 * spacing))), 0.0),
        thickness_(thickness),
        reach_(reach),
        histories_{{{0, 0}}} {}

  /// @param x extent of the facet through the thickness
  /// @pre times ascend
  void open(double time, double advance, const std::array<double, 2>& x) {
    if (time > 0 && advance > tip() + reach_) {
      ahead_.push_back({advance, x});
      return;
    }
    take(advance, x);
    const bool jumped = join();
    const double position = mean();
    if (jumped) {
      histories_.push_back({{time, position}});
      return;
    }
    auto& history = histories_.back();
    if (position <= history.back().advance) return;
    if (time > history.back().time) history.push_back({time, position});
    history.back().advance = position;
  }

  /// Mean positions over the thickness. The first history begins with the front at the start of the dynamic
  /// phase; another one begins wherever the front jumped over what was open ahead of it.
  const std::vector<std::vector<FrontPosition>>& histories() const { return histories_; }

private:
  struct Ahead {
    double advance;
    std::array<double, 2> x;
  };

  double tip() const { return *std::max_element(farthest_.begin(), farthest_.end()); }

  double mean() const {
    double sum = 0;
    for (const double value : farthest_) sum += value / static_cast<double>(farthest_.size());
    return sum;
  }

  void take(double advance, const std::array<double, 2>& x) {
    const auto column_of = [&](double place) {
      const double column = std::floor(place / thickness_ * static_cast<double>(farthest_.size()));
      return static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(farthest_.size() - 1)));
    };
    const std::size_t last = column_of(x[1]);
    for (std::size_t c = column_of(x[0]); c <= last; ++c) farthest_[c] = std::max(farthest_[c], advance);
  }

  /// Takes in what was ahead and lies before the front now; whether the front jumps by that.
  bool join() {
    const double before = tip();
    for (;;) {
      const auto near = std::partition(ahead_.begin(), ahead_.end(),
                                       [&](const Ahead& facet) { return facet.advance > tip() + gap_; });
      if (near == ahead_.end()) return tip() > before + gap_;
      std::for_each(near, ahead_.end(), [&](const Ahead& facet) { take(facet.advance, facet.x); });
      ahead_.erase(near, ahead_.end());
    }
  }

  double gap_;
  std::vector<double> farthest_;  // of each column through the thickness
  double thickness_;
  double reach_;
  std::vector<std::vector<FrontPosition>> histories_;
  std::vector<Ahead> ahead_;
};

Front front_of(const CrackSurface& surface, std::span<const std::size_t> facets, const NotchFrame& frame,
               double spacing, double thickness, double reach) {
  Front front(thickness, spacing, reach);
  for (const std::size_t i : facets) {  // in order of breaking, hence of time
    const CrackFacet& facet = surface.facets[i];
    double advance = 0;
    for (const geometry::Point& corner : facet.corner) {
      advance += frame.advance(corner[static_cast<std::size_t>(frame.axis)]) / 4;
    }
    const Trace box = extent(surface, i, frame.across);
    front.open(facet.time, advance, {box.x[0], box.x[1]});
  }
  return front;
}

/// The time at which a front passes a position between its first and its last.
double passing_time(const std::vector<FrontPosition>& front, double advance) {
  std::size_t k = 1;
  while (k + 1 < front.size() && front[k].advance < advance) ++k;
  const double share = (advance - front[k - 1].advance) / (front[k].advance - front[k - 1].advance);
  return front[k - 1].time + share * (front[k].time - front[k - 1].time);
}

/// Largest speed over a window; 0 when the front advances by less.
double fastest(const std::vector<FrontPosition>& front, double window) {
  double largest = 0;
  // The time over a window is piecewise linear in its position: its least value is at one of the front's
  // recorded positions, at the window's start or at its end.
  const double first = front.front().advance;
  const double last = front.back().advance;
  if (last - first < window) return 0;
  for (const FrontPosition& position : front) {
    for (const double start : {position.advance, position.advance - window}) {
      if (start < first || start + window > last) continue;
      const double time = passing_time(front, start + window) - passing_time(front, start);
      largest = std::max(largest, window / time);
    }
  }
  return largest;
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
    const Front front = front_of(surface, facets, frame, spacing, body.size()[0], window);
    for (const auto& history : front.histories()) largest = std::max(largest, fastest(history, window));
  }
  return largest;
}

}  // namespace crackle::analysis
