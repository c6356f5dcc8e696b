// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace crackle::analysis {

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

}  // namespace crackle::analysis
