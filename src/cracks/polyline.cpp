// SPDX-License-Identifier: GPL-3.0-or-later
#include "polyline.h"

#include "common/real.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace crackle::cracks {

Polyline::Polyline(std::vector<Place> places) : places_(std::move(places)), arc_length_{0} {
  for (std::size_t i = 1; i < places_.size(); ++i) {
    arc_length_.push_back(arc_length_.back() + std::hypot(places_[i].advance - places_[i - 1].advance,
                                                          places_[i].across - places_[i - 1].across));
  }
}

double Polyline::direction(double from, double to) const {
  const Place start = at(from);
  const double length = to - from;
  Place a{0, 0};  // relative to the start
  Place mean{0, 0};
  double advance_square = 0;
  double product = 0;
  double across_square = 0;
  for (std::size_t i = segment(from); from < to; ++i) {
    const double end = i + 1 < places_.size() ? std::min(arc_length_[i], to) : to;
    const Place b{at(end).advance - start.advance, at(end).across - start.across};
    const double share = (end - from) / length;
    mean.advance += share * (a.advance + b.advance) / 2;
    mean.across += share * (a.across + b.across) / 2;
    // Simpson's rule is exact for the squares on a straight piece.
    const Place middle{(a.advance + b.advance) / 2, (a.across + b.across) / 2};
    for (const auto& [p, weight] : {std::pair{a, share / 6}, {middle, share * 4 / 6}, {b, share / 6}}) {
      advance_square += weight * p.advance * p.advance;
      product += weight * p.advance * p.across;
      across_square += weight * p.across * p.across;
    }
    a = b;
    from = end;
  }
  const double angle = std::atan2(2 * (product - mean.advance * mean.across),
                                  (advance_square - mean.advance * mean.advance) -
                                      (across_square - mean.across * mean.across)) /
                       2;
  // An axis has two directions: choose the one along the path.
  const bool is_backward = std::cos(angle) * a.advance + std::sin(angle) * a.across < 0;
  return is_backward ? angle + std::numbers::pi : angle;
}

double Polyline::foot(const Place& p) const {
  double least = infinity;
  double foot = 0;
  for (std::size_t i = 1; i < places_.size(); ++i) {
    const Place& a = places_[i - 1];
    const double advance = places_[i].advance - a.advance;
    const double across = places_[i].across - a.across;
    const double length = arc_length_[i] - arc_length_[i - 1];
    if (!(length > 0)) continue;
    const double low = i == 1 ? -infinity : 0;
    const double high = i + 1 == places_.size() ? infinity : 1;
    const double share = std::clamp(
        ((p.advance - a.advance) * advance + (p.across - a.across) * across) / (length * length), low, high);
    const double distance =
        std::hypot(p.advance - a.advance - share * advance, p.across - a.across - share * across);
    if (distance >= least) continue;
    least = distance;
    foot = arc_length_[i - 1] + share * length;
  }
  return foot;
}

Polyline Polyline::smoothed(double reach) const {
  std::vector<Place> smooth = places_;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const double here = arc_length_[i];
    const double middle =
        std::clamp(here, std::min(reach, length() / 2), std::max(length() - reach, length() / 2));
    LineFit advance, across;
    for (std::size_t j = 0; j < places_.size(); ++j) {
      if (std::abs(arc_length_[j] - middle) > reach) continue;
      advance.add(arc_length_[j] - here, places_[j].advance - places_[i].advance);
      across.add(arc_length_[j] - here, places_[j].across - places_[i].across);
    }
    if (!(advance.variance() > 0)) continue;
    smooth[i].advance += advance.at(0);
    smooth[i].across += across.at(0);
  }
  return Polyline(std::move(smooth));
}

std::size_t Polyline::segment(double length) const {
  const auto end = std::upper_bound(arc_length_.begin() + 1, arc_length_.end() - 1, length);
  return static_cast<std::size_t>(end - arc_length_.begin());
}

Polyline::Place Polyline::at(double length) const {
  const std::size_t i = segment(length);
  const double share = (length - arc_length_[i - 1]) / (arc_length_[i] - arc_length_[i - 1]);
  return {places_[i - 1].advance + share * (places_[i].advance - places_[i - 1].advance),
          places_[i - 1].across + share * (places_[i].across - places_[i - 1].across)};
}

}  // namespace crackle::cracks
