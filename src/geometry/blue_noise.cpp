// SPDX-License-Identifier: GPL-3.0-or-later
#include "blue_noise.h"

#include "crackle/common/vector.h"

#include "repulsion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr double candidates_per_point = 3;

double power(double value, bool flat) {
  return flat ? value * value : value * value * value;
}

double measure(const Box& region) {
  double product = 1;
  for (std::size_t i = 0; i < 3; ++i)
    if (region.upper[i] > region.lower[i]) product *= region.upper[i] - region.lower[i];
  return product;
}

/// Calls `visit` for boxes that fill a region of the patch and are so small that the spacing varies little in
/// them, until it returns false.
template <class Visit>
bool subdivide(const SpacingField& spacing, const Patch& patch, const Box& region, const Visit& visit) {
  const std::size_t longest = longest_axis(region);
  const Point middle = region.lower + (region.upper - region.lower) / 2;
  const double length = region.upper[longest] - region.lower[longest];
  if (length <= 2 * spacing(patch.at(middle)) && length <= 4 * spacing.lower_bound(patch.bounds(region)))
    return visit(region);
  Box first = region;
  first.upper[longest] = middle[longest];
  Box second = region;
  second.lower[longest] = middle[longest];
  return subdivide(spacing, patch, first, visit) && subdivide(spacing, patch, second, visit);
}

/// True if a box is known to lie in the room, from the clearance of its middle.
bool has_room_everywhere(const SpacingField& spacing, const Patch& patch, const Room& room, const Box& cell) {
  const double clearance = room.clearance(patch.at(cell.lower + (cell.upper - cell.lower) / 2));
  return clearance - norm(cell.upper - cell.lower) / 2 >=
         room.margin * spacing.upper_bound(patch.bounds(cell));
}

/// Random points of the required density. Their number in a part of the patch is that required there, nearly
/// without scatter: every time that the sum over the candidates of the number of points that each stands for
/// passes an integer, the candidate is taken.
SpacedPoints start(const SpacingField& spacing, const Patch& patch, const Room& room, RandomStream& stream) {
  const bool flat = is_flat(patch.domain);
  const double density = candidates_per_point * (flat ? surface_density : interior_density);
  SpacedPoints result;
  double remainder = stream.uniform();
  double number = stream.uniform();
  subdivide(spacing, patch, patch.domain, [&](const Box& cell) {
    const double finest = spacing.lower_bound(patch.bounds(cell));
    const bool is_inside = has_room_everywhere(spacing, patch, room, cell);
    remainder += density * measure(cell) / power(finest, flat);
    for (; remainder >= 1; --remainder) {
      Point own = cell.lower;
      for (std::size_t i = 0; i < 3; ++i)
        if (cell.upper[i] > cell.lower[i]) own[i] = stream.uniform(cell.lower[i], cell.upper[i]);
      const Point p = patch.at(own);
      const double local = spacing(p);
      if (!is_inside && room.clearance(p) < room.margin * local) continue;
      number += power(finest, flat) / (power(local, flat) * candidates_per_point);
      if (number < 1) continue;
      --number;
      result.position.push_back(p);
      result.spacing.push_back(local);
    }
    return true;
  });
  return result;
}

}  // namespace

std::vector<Point> blue_noise(const SpacingField& spacing, const Patch& patch, const Room& room,
                              const SpacedPoints& fixed, RandomStream stream) {
  SpacedPoints points = start(spacing, patch, room, stream);
  repel(spacing, patch, room, fixed, points, stream);
  return std::move(points.position);
}

double expected_points(const SpacingField& spacing, const Patch& patch, const Room& room, double limit) {
  const bool flat = is_flat(patch.domain);
  const double density = flat ? surface_density : interior_density;
  double sum = 0;
  subdivide(spacing, patch, patch.domain, [&](const Box& cell) {
    // The midpoints of 2 x 2 x 2 parts of the cell or, near the borders, of 4 x 4 x 4; 2 x 2 or 4 x 4 if
    // flat.
    const bool is_inside = has_room_everywhere(spacing, patch, room, cell);
    const unsigned n_along = is_inside ? 2 : 4;
    const unsigned n_parts = flat ? n_along * n_along : n_along * n_along * n_along;
    double mean = 0;
    for (unsigned part = 0; part < n_parts; ++part) {
      Point own = cell.lower;
      unsigned rest = part;
      for (unsigned i = 0; i < 3; ++i) {
        if (cell.upper[i] == cell.lower[i]) continue;
        own[i] += (0.5 + rest % n_along) / n_along * (cell.upper[i] - cell.lower[i]);
        rest /= n_along;
      }
      const Point p = patch.at(own);
      const double local = spacing(p);
      if (is_inside || room.clearance(p) >= room.margin * local) mean += 1 / (n_parts * power(local, flat));
    }
    sum += density * measure(cell) * mean;
    return sum <= limit;
  });
  return sum;
}

}  // namespace crackle::geometry
