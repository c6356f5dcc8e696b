// SPDX-License-Identifier: GPL-3.0-or-later
#include "near_pairs.h"

#include "common/index.h"
#include "common/vector.h"
#include "geometry/box.h"

#include <algorithm>
#include <array>
#include <bit>

namespace crackle::geometry {

namespace {

struct Sphere {
  Point position;
  double radius;
  std::uint64_t column;  ///< that contains its cell
  std::int32_t number;
};

/// Spheres sorted by cubic cells. The cells of a column, along z, have consecutive slots in a hash table.
class Cells {
public:
  Cells(const Point& origin, double width, std::size_t n)
      : origin_(origin), width_(width), mask_(std::bit_ceil(std::max<std::size_t>(2 * n, 4)) - 1) {}

  void fill(std::span<const Point> points, std::span<const double> radius,
            std::span<const std::int32_t> members) {
    begin_.assign(mask_ + 2, 0);
    for (const std::int32_t i : members) largest_ = std::max(largest_, radius[index(i)]);
    std::vector<std::size_t> slot(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      slot[k] = slot_of(cell_of(points[index(members[k])]));
      ++begin_[slot[k] + 1];
    }
    for (std::size_t i = 0; i <= mask_; ++i) begin_[i + 1] += begin_[i];
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    spheres_.resize(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      const std::size_t i = index(members[k]);
      spheres_[next[slot[k]]++] = {points[i], radius[i], column_of(cell_of(points[i])), members[k]};
    }
  }

  /// Visits the spheres whose distance from another one is below the mean radius.
  /// @param each_pair_once if the other one is among these: visits only those in the following cells, and
  /// those
  ///   in the same cell with larger numbers
  template <class Visit>
  void around(const Sphere& other, bool each_pair_once, const Visit& visit) const {
    const Cell centre = cell_of(other.position);
    // Squared distances, along each axis, to the neighbours before, at and after the own cell: most of the
    // outer cells are farther away than any sphere that could reach.
    const double reach = (largest_ + other.radius) / 2;
    const double limit = reach * reach * (1 + 1e-12);
    std::array<std::array<double, 3>, 3> gap{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double before = other.position[i] - origin_[i] - static_cast<double>(centre[i]) * width_;
      gap[i] = {before * before, 0, (width_ - before) * (width_ - before)};
    }
    const std::int64_t first = each_pair_once ? 0 : -1;
    for (std::int64_t x = first; x <= 1; ++x)
      for (std::int64_t y = x == 0 ? first : -1; y <= 1; ++y) {
        const double beside = gap[0][index(x + 1)] + gap[1][index(y + 1)];
        if (beside >= limit) continue;
        const bool is_own = each_pair_once && x == 0 && y == 0;
        if (is_own) scan(centre, 1, other, other.number, visit);
        const std::int64_t from = is_own ? 1 : beside + gap[2][0] < limit ? -1 : 0;
        const std::int64_t to = beside + gap[2][2] < limit ? 1 : 0;
        if (from <= to)
          scan({centre[0] + x, centre[1] + y, centre[2] + from}, index(to - from + 1), other, -1, visit);
      }
  }

private:
  using Cell = std::array<std::int64_t, 3>;

  Cell cell_of(const Point& p) const {
    Cell cell{};
    for (std::size_t i = 0; i < 3; ++i) cell[i] = static_cast<std::int64_t>((p[i] - origin_[i]) / width_);
    return cell;
  }
  static std::uint64_t column_of(const Cell& cell) {
    return (static_cast<std::uint64_t>(cell[0]) << 32) | static_cast<std::uint64_t>(cell[1]);
  }
  std::size_t slot_of(const Cell& cell) const {
    const std::uint64_t mixed = column_of(cell) * 0x9E3779B97F4A7C15u;
    return ((mixed >> 32) + static_cast<std::uint64_t>(cell[2])) & mask_;
  }

  /// Visits the spheres in `n` cells from `lowest` on whose numbers are above `after`.
  template <class Visit>
  void scan(const Cell& lowest, std::size_t n, const Sphere& other, std::int32_t after,
            const Visit& visit) const {
    const std::uint64_t column = column_of(lowest);
    const auto scan_slots = [&](std::size_t from, std::size_t to) {
      for (std::size_t k = begin_[from]; k < begin_[to]; ++k) {
        const Sphere& sphere = spheres_[k];
        const Point gap = sphere.position - other.position;
        const double reach = (sphere.radius + other.radius) / 2;
        // Other columns may have the same slots.
        if (dot(gap, gap) < reach * reach && sphere.column == column && sphere.number > after)
          visit(sphere.number);
      }
    };
    const std::size_t slot = slot_of(lowest);
    const std::size_t end = std::min(slot + n, mask_ + 1);
    scan_slots(slot, end);
    scan_slots(0, slot + n - end);
  }

  Point origin_;
  double width_;
  double largest_ = 0;              ///< radius
  std::size_t mask_;                ///< number of slots - 1
  std::vector<std::size_t> begin_;  ///< by slot
  std::vector<Sphere> spheres_;     ///< by slot
};

}  // namespace

NearPairs near_pairs(std::span<const Point> points, std::span<const double> radius, std::size_t n_movable) {
  NearPairs pairs;
  pairs.first.assign(points.size() + 1, 0);
  if (points.empty()) return pairs;
  const double finest = *std::ranges::min_element(radius);
  Box bounds = nowhere;
  std::vector<std::vector<std::int32_t>> members;  // by level, which is that of the cells of twice the width
  std::vector<std::uint8_t> level(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    bounds.include(points[i]);
    for (double width = finest; width < radius[i]; width *= 2) ++level[i];
    if (level[i] >= members.size()) members.resize(level[i] + std::size_t{1});
    members[level[i]].push_back(static_cast<std::int32_t>(i));
  }
  std::vector<Cells> levels;
  double width = finest;
  for (const auto& each : members) {
    // Two cells more on each side, so that no cell has a negative number.
    levels.emplace_back(bounds.lower - Point{2 * width, 2 * width, 2 * width}, width, each.size());
    levels.back().fill(points, radius, each);
    width *= 2;
  }
  pairs.other.reserve(10 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    // A pair of different levels is found from the finer one, at whose side the cells are wide enough.
    for (std::size_t l = level[i]; l < levels.size(); ++l)
      levels[l].around({points[i], radius[i], 0, static_cast<std::int32_t>(i)}, l == level[i],
                       [&](std::int32_t j) {
                         if (i < n_movable || index(j) < n_movable) pairs.other.push_back(j);
                       });
    pairs.first[i + 1] = pairs.other.size();
  }
  return pairs;
}

}  // namespace crackle::geometry
