// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

namespace crackle::cracks {

/// A path in the plane of the plate, straight between its points; at least two.
class Polyline {
public:
  struct Place {
    double advance;  ///< [m]
    double across;   ///< [m]

    friend Place operator-(const Place& a, const Place& b) {
      return {a.advance - b.advance, a.across - b.across};
    }
  };

  explicit Polyline(std::vector<Place> places);

  const Place& front() const { return places_.front(); }
  double length() const { return arc_length_.back(); }
  const std::vector<double>& arc_lengths() const { return arc_length_; }  ///< at each point [m]

  /// Angle to the advance of the straight line fitted to a part of the path by total least squares [rad].
  /// @param from,to arc lengths along the path
  double direction(double from, double to) const;

  /// Arc length of the point nearest to p of the path, straight on beyond its ends: there it is negative or
  /// more than length() [m].
  double foot(const Place& p) const;

  /// The path without the scatter of its points: each is moved to the straight line fitted to those within
  /// `reach` to both sides along the path, or within twice as much to one side at an end.
  Polyline smoothed(double reach) const;

private:
  /// The segment that contains an arc length, by the index of its end.
  std::size_t segment(double length) const;
  Place at(double length) const;

  std::vector<Place> places_;
  std::vector<double> arc_length_;
};

/// A straight line fitted to points by least squares. Positions are best given relative to one near them.
class LineFit {
public:
  void add(double x, double y) {
    n_ += 1;
    s_ += x;
    t_ += y;
    ss_ += x * x;
    st_ += x * y;
  }

  double n() const { return n_; }                         ///< number of points
  double variance() const { return n_ * ss_ - s_ * s_; }  ///< of x, times n squared
  /// @pre variance() > 0
  double slope() const { return (n_ * st_ - s_ * t_) / variance(); }
  /// @pre variance() > 0
  double at(double x) const { return t_ / n_ + slope() * (x - s_ / n_); }

private:
  double n_ = 0, s_ = 0, t_ = 0, ss_ = 0, st_ = 0;
};

}  // namespace crackle::cracks
