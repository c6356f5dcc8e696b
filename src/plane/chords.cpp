// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/plane/chords.h"

#include "crackle/common/index.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace crackle::plane {

ChordApproximation chord_approximation(const Shape& shape, const std::string& part, const Point& centre,
                                       const Point& semi_axes, double angle) {
  const Point along{std::cos(angle), std::sin(angle)};
  ChordApproximation found;
  double area = 0;
  for (const Loop& loop : shape.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      if (shape.parts[index(loop.part[i])].name != part) continue;
      const Point from = loop.from(i) - centre;
      const Point to = loop.to(i) - centre;
      const Point middle{(from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
      ++found.n_chords;
      found.longest = std::max(found.longest, norm(to - from));
      found.inside = std::max(
          found.inside, 1 - norm({dot(middle, along) / semi_axes[0], cross(along, middle) / semi_axes[1]}));
      area += cross(from, to) / 2;
    }
  found.area = std::abs(area) / (std::numbers::pi * semi_axes[0] * semi_axes[1]);
  return found;
}

}  // namespace crackle::plane
