// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/crack_speed.h"

#include "projection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace crackle::cracks {

namespace {

using Opened = FrontTrajectory::Opened;

/// Number of Legendre polynomials P_0 to P_3: a course is a line or a parabola, and the next degree tells
/// whether that is enough.
constexpr std::size_t n_coefficients = 4;
constexpr std::size_t largest_degree = n_coefficients - 2;
/// The columns of a front can lead its mean over a window by this factor; more where branches run side by
/// side.
constexpr double columns_lead = 1.25;
using Coefficients = std::array<double, n_coefficients>;

Coefficients legendre(double u) {
  return {1, u, (3 * u * u - 1) / 2, (5 * u * u - 3) * u / 2};
}

/// Mean square of P_k over its interval.
double legendre_square(std::size_t k) {
  return 1 / (2 * static_cast<double>(k) + 1);
}

/// The times at which a column of the front first reached positions ahead of all earlier ones; both strictly
/// ascending.
class Course {
public:
  void add(double time, double advance) {
    if (!points_.empty() && time <= points_.back().time) {
      points_.back().advance = std::max(points_.back().advance, advance);
      return;
    }
    points_.push_back({time, advance});
  }

  bool covers(double from, double to) const {
    return points_.size() > 1 && points_.front().advance <= from && points_.back().advance >= to;
  }
  bool is_empty() const { return points_.empty(); }
  double first() const { return points_.front().advance; }
  double last() const { return points_.back().advance; }

  struct Fit {
    Coefficients coefficient{};  ///< of the Legendre polynomials over the stretch [s]
    double square = 0;           ///< mean square of the time [s^2]
  };
  /// Least-squares fit of the time over a stretch; the time is linear between the points and counted from the
  /// stretch's start.
  /// @pre covers(from, to)
  Fit fit(double from, double to) const {
    auto after = std::upper_bound(points_.begin() + 1, points_.end() - 1, from,
                                  [](double advance, const Point& p) { return advance < p.advance; });
    const double origin = time_at(after, from);
    Fit fit;
    double time = 0;
    for (double u = -1; u < 1; ++after) {
      const bool is_last = after->advance >= to || after + 1 == points_.end();
      const double next = is_last ? 1 : 2 * (after->advance - from) / (to - from) - 1;
      const double next_time = (is_last ? time_at(after, to) : after->time) - origin;
      // Gauss quadrature: exact for the linear time multiplied by a cubic.
      constexpr double outer = 0.7745966692414834;
      for (const auto& [place, weight] :
           {std::pair{-outer, 5.0 / 18}, std::pair{0.0, 8.0 / 18}, std::pair{outer, 5.0 / 18}}) {
        const double share = (1 + place) / 2;
        const double value = time + share * (next_time - time);
        const double part = weight * (next - u) / 2;
        const Coefficients p = legendre(u + share * (next - u));
        for (std::size_t k = 0; k < n_coefficients; ++k) {
          fit.coefficient[k] += part * value * p[k] / legendre_square(k);
        }
        fit.square += part * value * value;
      }
      u = next;
      time = next_time;
    }
    return fit;
  }

private:
  struct Point {
    double time;
    double advance;
  };

  double time_at(std::vector<Point>::const_iterator after, double advance) const {
    const Point& a = *(after - 1);
    const Point& b = *after;
    return a.time + (advance - a.advance) / (b.advance - a.advance) * (b.time - a.time);
  }

  std::vector<Point> points_;
};

/// The courses of all columns through the thickness.
using History = std::vector<Course>;

/// An advancing crack front. What opens farther than front_reach ahead of it, or nearer but as part of what
/// has opened there, counts once the front has come there.
class Front {
public:
  Front(double thickness, double spacing)
      : gap_(spacing),
        farthest_(std::max<std::size_t>(1, static_cast<std::size_t>(thickness / (2 * spacing))), 0.0),
        thickness_(thickness),
        reach_(front_reach * spacing),
        histories_{History(farthest_.size())} {}

  /// @pre times ascend
  void open(const Opened& opened) {
    const bool is_dynamic = opened.time > 0;
    if (is_dynamic && is_apart(opened)) {
      ahead_.push_back(opened);
      return;
    }
    take(opened, is_dynamic ? &histories_.back() : nullptr);
    if (join()) histories_.emplace_back(farthest_.size());
  }

  /// One history from the start of the dynamic phase on, and a new one after each jump of the front over
  /// earlier openings ahead of it.
  const std::vector<History>& histories() const { return histories_; }

private:
  double tip() const { return *std::max_element(farthest_.begin(), farthest_.end()); }

  bool is_apart(const Opened& opened) const {
    const double ahead = opened.place - tip();
    return ahead > reach_ || (ahead > gap_ && std::ranges::any_of(ahead_, [&](const Opened& other) {
                                return std::abs(other.place - opened.place) <= gap_;
                              }));
  }

  /// @param history to which the columns' advance is added; may be null
  void take(const Opened& opened, History* history) {
    const auto column_of = [&](double place) {
      const double column = std::floor(place / thickness_ * static_cast<double>(farthest_.size()));
      return static_cast<std::size_t>(std::clamp(column, 0.0, static_cast<double>(farthest_.size() - 1)));
    };
    const std::size_t last = column_of(opened.x[1]);
    for (std::size_t c = column_of(opened.x[0]); c <= last; ++c) {
      if (opened.place <= farthest_[c]) continue;
      farthest_[c] = opened.place;
      if (history != nullptr) (*history)[c].add(opened.time, opened.place);
    }
  }

  /// Merges earlier openings that the front has now reached; true if the front jumps as a result.
  bool join() {
    const double before = tip();
    for (;;) {
      const auto near = std::partition(ahead_.begin(), ahead_.end(),
                                       [&](const Opened& o) { return o.place > tip() + gap_; });
      if (near == ahead_.end()) return tip() > before + gap_;
      std::for_each(near, ahead_.end(), [&](const Opened& o) { take(o, nullptr); });
      ahead_.erase(near, ahead_.end());
    }
  }

  double gap_;
  std::vector<double> farthest_;  // per column through the thickness
  double thickness_;
  double reach_;
  std::vector<History> histories_;
  std::vector<Opened> ahead_;
};

/// A front's course over a stretch of its path, averaged over the columns that passed all of it.
struct Stretch {
  double start;              ///< [m]
  double length;             ///< [m]
  double n_columns;          ///< columns that passed it
  Coefficients coefficient;  ///< of their mean course [s]
  std::array<double, largest_degree + 1>
      scatter;  ///< variance of a column about its fit of this degree [s^2]
};

/// Stretches of many lengths and positions that at least half of the columns passed.
std::vector<Stretch> stretches_of(const History& history, double shortest) {
  // Fine enough that the largest speed changes by less than its standard error.
  constexpr double growth = 1.189207115002721;  // four lengths per doubling
  constexpr int n_steps = 16;                   // per length
  double first = infinity;
  double last = 0;
  for (const Course& course : history) {
    if (course.is_empty()) continue;
    first = std::min(first, course.first());
    last = std::max(last, course.last());
  }
  std::vector<Stretch> stretches;
  for (double length = shortest; length <= last - first; length *= growth) {
    for (double start = first; start + length <= last; start += length / n_steps) {
      Stretch stretch{start, length, 0, {}, {}};
      for (const Course& course : history) {
        if (!course.covers(start, start + length)) continue;
        ++stretch.n_columns;
        const Course::Fit fit = course.fit(start, start + length);
        double rest = fit.square;
        for (std::size_t k = 0; k < n_coefficients; ++k) {
          stretch.coefficient[k] += fit.coefficient[k];
          rest -= fit.coefficient[k] * fit.coefficient[k] * legendre_square(k);
          if (k <= largest_degree) stretch.scatter[k] += std::max(0.0, rest);
        }
      }
      if (2 * stretch.n_columns < static_cast<double>(history.size())) continue;
      for (double& value : stretch.coefficient) value /= stretch.n_columns;
      for (double& value : stretch.scatter) value /= stretch.n_columns;
      stretches.push_back(stretch);
    }
  }
  return stretches;
}

/// The time over a window according to the polynomial of this degree [s].
/// @param start of the window, in the stretch from -1 to 1
/// @param width of the window, where the stretch has 2
double time_over(const Stretch& stretch, std::size_t degree, double start, double width) {
  const Coefficients from = legendre(start);
  const Coefficients to = legendre(start + width);
  double time = 0;
  for (std::size_t k = 1; k <= degree; ++k) time += stretch.coefficient[k] * (to[k] - from[k]);
  return time;
}

/// All windows of a front's path, and the accuracy of their times.
class Windows {
public:
  /// @param stretches in ascending order of length, starting with those of one window
  Windows(const std::vector<Stretch>& stretches, const FrontTrajectory& trajectory)
      : length_(trajectory.window), spacing_(trajectory.spacing) {
    std::vector<double> scatter;
    for (const Stretch& stretch : stretches) {
      if (stretch.length > length_) break;
      windows_.push_back(stretch);
      scatter.push_back(stretch.scatter[1]);
      const double end = stretch.start + stretch.length;
      const double wave = stretch.length * trajectory.slowness(stretch.start, end);
      if (wave > 0 && time_over(stretch, 1, -1, 2) < wave) jumps_.emplace_back(stretch.start, end);
    }
    for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
      const FrontTrajectory::Point& point = trajectory.points[i];
      if (point.run < 0) jumps_.emplace_back(point.place, point.place);
    }
    if (scatter.empty()) return;
    // The lower quartile: changes of speed add to the scatter.
    const auto quartile = scatter.begin() + static_cast<std::ptrdiff_t>(scatter.size() / 4);
    std::nth_element(scatter.begin(), quartile, scatter.end());
    scatter_ = *quartile;
  }

  bool is_empty() const { return windows_.empty(); }

  /// True if the stretch overlaps a window that the front passes faster than a Rayleigh wave, which no crack
  /// does: it has jumped to what opened on its own ahead of it or beside it.
  bool has_jump(const Stretch& stretch) const {
    return std::ranges::any_of(jumps_, [&](const auto& jump) {
      return jump.first < stretch.start + stretch.length && jump.second > stretch.start;
    });
  }

  /// True if a polynomial fits the stretch within its scatter: the next degree adds little, and the time of
  /// each window in the stretch agrees with the polynomial.
  bool agree(const Stretch& stretch, std::size_t degree) const {
    const double rounding = 1e-9 * std::abs(stretch.coefficient[1]);  // for courses without scatter
    const double next = std::abs(stretch.coefficient[degree + 1]) * std::sqrt(legendre_square(degree + 1));
    if (next > 2 * std::sqrt(variance(stretch, scatter_)) + rounding) return false;
    const double width = 2 * length_ / stretch.length;
    return std::all_of(windows_.begin(), windows_.end(), [&](const Stretch& window) {
      const double start = 2 * (window.start - stretch.start) / stretch.length - 1;
      if (start < -1 || start + width > 1) return true;
      const double difference = time_over(window, 1, -1, 2) - time_over(stretch, degree, start, width);
      return std::abs(difference) <= speed_standard_errors * error(window, 1, -1, 2) + rounding;
    });
  }

  /// Standard error of time_over [s].
  double error(const Stretch& stretch, std::size_t degree, double start, double width) const {
    const double n_free = 1 - static_cast<double>(degree + 1) * spacing_ / stretch.length;
    const Coefficients from = legendre(start);
    const Coefficients to = legendre(start + width);
    double square = 0;
    for (std::size_t k = 1; k <= degree; ++k) {
      square += (to[k] - from[k]) * (to[k] - from[k]) / legendre_square(k);
    }
    return std::sqrt(square * variance(stretch, std::max(scatter_, stretch.scatter[degree] / n_free)));
  }

private:
  /// Variance of P_k's coefficient times the mean square of P_k, for any k: a column advances by about a
  /// spacing at a time, which gives the number of independent times.
  double variance(const Stretch& stretch, double scatter) const {
    return scatter * spacing_ / (stretch.length * stretch.n_columns);
  }

  double length_;
  double spacing_;
  double scatter_ = 0;  ///< of a column's time about a line over a window [s^2]
  std::vector<Stretch> windows_;
  std::vector<std::pair<double, double>> jumps_;  ///< windows with a jump, from and to [m]
};

/// Raises the largest speed, and the largest ratio to the Rayleigh speed there, to those over a window; NaN
/// counts as less than any.
void raise(CrackSpeed& largest, const History& history, const FrontTrajectory& trajectory) {
  const double window = trajectory.window;
  const std::vector<Stretch> stretches = stretches_of(history, window);
  const Windows windows(stretches, trajectory);
  if (windows.is_empty()) return;
  CrackSpeed found;
  double least_upper = infinity, least_upper_ratio = infinity;
  for (const Stretch& stretch : stretches) {
    if (windows.has_jump(stretch)) continue;
    for (std::size_t degree = 1; degree <= largest_degree; ++degree) {
      // A parabola needs more than one window of data, and is steepest at an end.
      if (degree > 1 && stretch.length < 2 * window) break;
      if (stretch.length > window && !windows.agree(stretch, degree)) continue;
      const double width = 2 * window / stretch.length;
      for (const double start : {-1.0, 1 - width}) {
        const double time = time_over(stretch, degree, start, width);
        const double upper = time + speed_standard_errors * windows.error(stretch, degree, start, width);
        if (time <= 0) continue;
        const double from = stretch.start + (start + 1) / 2 * stretch.length;
        const double slowness = trajectory.slowness(from, from + window);
        if (window * slowness > time || time * columns_lead < trajectory.mean_time(from, from + window))
          continue;
        if (upper < least_upper) {
          least_upper = upper;
          found.largest = window / time;
        }
        if (upper / slowness < least_upper_ratio) {
          least_upper_ratio = upper / slowness;
          found.largest_ratio = window / time * slowness;
        }
      }
    }
  }
  largest.largest = std::fmax(largest.largest, found.largest);
  largest.largest_ratio = std::fmax(largest.largest_ratio, found.largest_ratio);
}

}  // namespace

CrackSpeed max_crack_speed(const geometry::Body& body, std::span<const FrontTrajectory> trajectories) {
  CrackSpeed largest;
  for (const FrontTrajectory& trajectory : trajectories) {
    Front front(Projection(body).thickness(), trajectory.spacing);
    for (const Opened& opened : trajectory.opened) front.open(opened);
    for (const History& history : front.histories()) raise(largest, history, trajectory);
  }
  return largest;
}

}  // namespace crackle::cracks
