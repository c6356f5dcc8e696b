// SPDX-License-Identifier: GPL-3.0-or-later
#include "displacement.h"

#include "crackle/common/index.h"

namespace crackle::geometry {

Point displaced(const Body& body, const Point& centre, std::uint8_t movable, double radius,
                RandomStream stream) {
  if (movable == 0 || radius == 0) return centre;
  const Directions directions = body.directions(centre, movable);
  // The centre is in the body, so at least an eighth of the ball is too: this many draws all fail with
  // probability below 1e-30.
  for (int draw = 0; draw < 1000; ++draw) {
    Point p = centre;
    double squared = 0;
    for (int k = 0; k < directions.n; ++k) {
      const double offset = stream.uniform(-1, 1);
      squared += offset * offset;
      p = p + radius * offset * directions.vector[index(k)];
    }
    if (squared <= 1 && body.contains(p) && body.movable(p) == movable) return p;
  }
  return centre;
}

}  // namespace crackle::geometry
