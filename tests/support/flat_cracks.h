// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/vector.h"
#include "cracks/crack_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

namespace crackle::test {

/// Unit vector in the y-z plane, by its angle to y.
inline Vector direction(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return {0, std::cos(angle), std::sin(angle)};
}

/// Crack surfaces made of flat pieces through the thickness of a body, each of squares with a number of their
/// own in place of a tetrahedron's.
class FlatCracks {
public:
  /// When the crack arrives [s] at a distance from where a piece starts [m].
  using Arrival = std::function<double(double)>;

  /// @param step edge of the squares [m]
  explicit FlatCracks(double thickness, double step = 0.2e-3) : thickness_(thickness), step_(step) {}

  double step() const { return step_; }
  double spacing() const { return 3 * std::numbers::sqrt2 * step_; }

  /// Starts a new crack, to which further pieces belong.
  void begin(std::int32_t start) { surface_.cracks.push_back({start, 0, 0, 0}); }

  /// Starts a crack that continues another one of this start behind a hole.
  void go_on(std::int32_t start, std::int32_t hole, std::int32_t crack) {
    surface_.cracks.push_back({start, 0, 0, 0, hole});
    surface_.entries.push_back({hole, start, crack});
  }

  /// Adds a piece of this length.
  /// @return the time at its end
  double add(const geometry::Point& from, double degrees, double length, const Arrival& arrival) {
    const Vector along = direction(degrees);
    const int n_along = static_cast<int>(std::lround(length / step_));
    const int n_across = static_cast<int>(std::lround(thickness_ / step_));
    for (int i = 0; i < n_along; ++i) {
      for (int j = 0; j < n_across; ++j) {
        const auto corner = [&](int ahead, int across) {
          geometry::Point p = from + (i + ahead) * step_ * along;
          p[0] = (j + across) * step_;
          return p;
        };
        cracks::CrackFacet facet{};
        facet.corner = {corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)};
        facet.area = step_ * step_;
        facet.time = arrival((i + 0.5) * step_);
        facet.tetrahedron = static_cast<std::int64_t>(surface_.facets.size());
        facet.crack = static_cast<std::int32_t>(surface_.cracks.size()) - 1;
        surface_.facets.push_back(facet);
      }
    }
    return arrival(length);
  }

  /// Adds a piece that starts at a time and grows at a speed.
  double add(const geometry::Point& from, double degrees, double length, double speed, double time) {
    return add(from, degrees, length, [=](double place) { return time + place / speed; });
  }

  cracks::CrackSurface surface() const {
    cracks::CrackSurface sorted = surface_;
    std::ranges::stable_sort(sorted.facets, {}, &cracks::CrackFacet::time);
    return sorted;
  }

private:
  double thickness_;
  double step_;
  cracks::CrackSurface surface_;
};

}  // namespace crackle::test
