// SPDX-License-Identifier: GPL-3.0-or-later
#include "blue_noise.h"

#include "crackle/common/vector.h"

#include "point_tree.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr double candidates_per_point = 3;

bool is_flat(const Box& region) {
  for (std::size_t i = 0; i < 3; ++i)
    if (region.upper[i] == region.lower[i]) return true;
  return false;
}

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

SpacedPoints candidates(const SpacingField& spacing, const Patch& patch,
                        const std::function<bool(const Point&, double)>& accepts, RandomStream& stream) {
  const bool flat = is_flat(patch.domain);
  const double density = candidates_per_point * (flat ? surface_density : interior_density);
  SpacedPoints result;
  subdivide(spacing, patch, patch.domain, [&](const Box& cell) {
    const double finest = spacing.lower_bound(patch.bounds(cell));
    const double wanted = density * measure(cell) / power(finest, flat);
    const auto n_trials = static_cast<std::int64_t>(std::floor(wanted + stream.uniform()));
    for (std::int64_t trial = 0; trial < n_trials; ++trial) {
      Point own = cell.lower;
      for (std::size_t i = 0; i < 3; ++i)
        if (cell.upper[i] > cell.lower[i]) own[i] = stream.uniform(cell.lower[i], cell.upper[i]);
      const Point p = patch.at(own);
      const double local = spacing(p);
      if (power(finest, flat) < stream.uniform() * power(local, flat)) continue;
      if (!accepts(p, local)) continue;
      result.position.push_back(p);
      result.spacing.push_back(local);
    }
    return true;
  });
  return result;
}

/// Elimination weight of two points at a distance from each other; 0 from `reach` local spacings on.
double weight(double distance, double spacing_sum, double reach) {
  const double x = 1 - 2 * distance / (spacing_sum * reach);
  if (x <= 0) return 0;
  const double x2 = x * x;
  return x2 * x2 * x2 * x2;
}

}  // namespace

std::vector<Point> blue_noise(const SpacingField& spacing, const Patch& patch,
                              const std::function<bool(const Point&, double spacing)>& accepts,
                              const SpacedPoints& fixed, RandomStream stream) {
  SpacedPoints pool = candidates(spacing, patch, accepts, stream);
  const std::size_t n_candidates = pool.position.size();
  const auto n_wanted = static_cast<std::size_t>(
      std::floor(static_cast<double>(n_candidates) / candidates_per_point + stream.uniform()));
  pool.position.insert(pool.position.end(), fixed.position.begin(), fixed.position.end());
  pool.spacing.insert(pool.spacing.end(), fixed.spacing.begin(), fixed.spacing.end());

  // Twice the radius of the densest packing of the required number of points, in local spacings. The roots of
  // 2 / (sqrt(3) density) and sqrt(2) / density are computed by Newton's iteration, which is bitwise equal on
  // every machine.
  const bool flat = is_flat(patch.domain);
  double reach = 1;
  for (int i = 0; i < 8; ++i)
    reach = flat ? (reach + 2 / (std::sqrt(3.0) * surface_density) / reach) / 2
                 : (2 * reach + std::sqrt(2.0) / interior_density / (reach * reach)) / 3;

  // A neighbour at distance d within reach has a spacing of at most spacing + growth d. Very steep growth is
  // cut off at twice the reach, for both points of a pair.
  const double steepness = std::min(1.0, reach * spacing.largest_growth());
  const double search = reach / (1 - steepness / 2);
  const PointTree tree(pool.position);
  std::vector<std::int32_t> near;
  const auto for_neighbours = [&](std::size_t i, const auto& visit) {
    tree.find(pool.position[i], search * pool.spacing[i], near);
    for (const std::int32_t j : near) {
      const auto other = static_cast<std::size_t>(j);
      if (other == i) continue;
      const double gap = norm(pool.position[other] - pool.position[i]);
      if (gap >= search * pool.spacing[other]) continue;
      const double w = weight(gap, pool.spacing[other] + pool.spacing[i], reach);
      if (w > 0) visit(other, w);
    }
  };

  std::vector<double> crowding(n_candidates, 0);
  std::vector<std::pair<double, std::int64_t>> keys(n_candidates);
  for (std::size_t i = 0; i < n_candidates; ++i) {
    for_neighbours(i, [&](std::size_t, double w) { crowding[i] += w; });
    keys[i] = {crowding[i], static_cast<std::int64_t>(i)};
  }
  // Weights only decrease, so an outdated key is too high: when popped, it is pushed back with its new value.
  std::priority_queue<std::pair<double, std::int64_t>> queue({}, std::move(keys));
  std::vector<std::uint8_t> alive(n_candidates, 1);
  for (std::size_t n_alive = n_candidates; n_alive > n_wanted;) {
    const auto [key, number] = queue.top();
    queue.pop();
    const auto i = static_cast<std::size_t>(number);
    if (crowding[i] != key) {
      queue.emplace(crowding[i], number);
      continue;
    }
    alive[i] = 0;
    --n_alive;
    for_neighbours(i, [&](std::size_t other, double w) {
      if (other < n_candidates && alive[other]) crowding[other] -= w;
    });
  }

  std::vector<Point> kept;
  kept.reserve(n_wanted);
  for (std::size_t i = 0; i < n_candidates; ++i)
    if (alive[i]) kept.push_back(pool.position[i]);
  return kept;
}

double expected_points(const SpacingField& spacing, const Patch& patch,
                       const std::function<bool(const Point&, double spacing)>& accepts, double limit) {
  const bool flat = is_flat(patch.domain);
  const double density = flat ? surface_density : interior_density;
  double sum = 0;
  subdivide(spacing, patch, patch.domain, [&](const Box& cell) {
    // The midpoints of 4 x 4 x 4 parts of the cell, or of 4 x 4 parts of a flat one.
    double mean = 0;
    const unsigned n_parts = flat ? 16 : 64;
    for (unsigned part = 0; part < n_parts; ++part) {
      Point own = cell.lower;
      unsigned rest = part;
      for (unsigned i = 0; i < 3; ++i) {
        if (cell.upper[i] == cell.lower[i]) continue;
        own[i] += (0.125 + 0.25 * (rest & 3u)) * (cell.upper[i] - cell.lower[i]);
        rest >>= 2;
      }
      const Point p = patch.at(own);
      const double local = spacing(p);
      if (accepts(p, local)) mean += 1 / (n_parts * power(local, flat));
    }
    sum += density * measure(cell) * mean;
    return sum <= limit;
  });
  return sum;
}

}  // namespace crackle::geometry
