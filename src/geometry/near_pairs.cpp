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
  double half_radius;
  std::uint64_t column;  ///< that contains its cell
  std::int32_t number;
};

/// The numbers found so far, at the front of a list that is longer.
struct Found {
  std::vector<std::int32_t>& numbers;
  std::size_t n = 0;

  /// Where more may be written.
  std::int32_t* room_for(std::size_t n_more) {
    if (numbers.size() < n + n_more) numbers.resize(2 * (n + n_more));
    return numbers.data() + n;
  }
  void set_end(const std::int32_t* end) { n = static_cast<std::size_t>(end - numbers.data()); }
};

/// Spheres sorted by cubic cells. The cells of a column, along z, have consecutive slots in a hash table.
class Cells {
public:
  Cells(const Point& origin, double width, std::size_t n)
      : origin_(origin), width_(width), mask_(std::bit_ceil(std::max<std::size_t>(2 * n, 4)) - 1) {}

  void fill(std::span<const Point> points, std::span<const double> radius,
            std::span<const std::int32_t> members) {
    // Counts of the slots two places on, then the place of each slot's next sphere one place on.
    begin_.assign(mask_ + 3, 0);
    std::vector<std::uint32_t> slot(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      largest_ = std::max(largest_, radius[index(members[k])]);
      slot[k] = static_cast<std::uint32_t>(slot_of(cell_of(points[index(members[k])])));
      ++begin_[slot[k] + std::size_t{2}];
    }
    for (std::size_t i = 2; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    spheres_.resize(members.size());
    for (std::size_t k = 0; k < members.size(); ++k) {
      const std::size_t i = index(members[k]);
      spheres_[begin_[slot[k] + std::size_t{1}]++] = {points[i], radius[i] / 2, column_of(cell_of(points[i])),
                                                      members[k]};
    }
  }

  /// Finds the spheres below number `limit` whose distance from another one is below the mean radius.
  /// @param each_pair_once if the other one is among these: finds only those in the following cells, and
  ///   those in the same cell with larger numbers
  void find_around(const Sphere& other, bool each_pair_once, std::int32_t limit, Found& found) const {
    const Cell centre = cell_of(other.position);
    // Squared distances, along each axis, to the neighbours before, at and after the own cell: most of the
    // outer cells are farther away than any sphere that could reach.
    const double reach = largest_ / 2 + other.half_radius;
    const double square = reach * reach * (1 + 1e-12);
    std::array<std::array<double, 3>, 3> gap{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double before = other.position[i] - origin_[i] - static_cast<double>(centre[i]) * width_;
      gap[i] = {before * before, 0, (width_ - before) * (width_ - before)};
    }
    const std::int64_t first = each_pair_once ? 0 : -1;
    for (std::int64_t x = first; x <= 1; ++x)
      for (std::int64_t y = x == 0 ? first : -1; y <= 1; ++y) {
        const double beside = gap[0][index(x + 1)] + gap[1][index(y + 1)];
        if (beside >= square) continue;
        const bool is_own = each_pair_once && x == 0 && y == 0;
        if (is_own) scan(centre, 1, other, other.number, limit, found);
        const std::int64_t from = is_own ? 1 : beside + gap[2][0] < square ? -1 : 0;
        const std::int64_t to = beside + gap[2][2] < square ? 1 : 0;
        if (from <= to)
          scan({centre[0] + x, centre[1] + y, centre[2] + from}, index(to - from + 1), other, -1, limit,
               found);
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

  /// Finds the spheres in `n` cells from `lowest` on whose numbers are above `after` and below `limit`.
  void scan(const Cell& lowest, std::size_t n, const Sphere& other, std::int32_t after, std::int32_t limit,
            Found& found) const {
    const std::uint64_t column = column_of(lowest);
    const auto scan_slots = [&](std::size_t from, std::size_t to) {
      const std::span each(spheres_.data() + begin_[from], spheres_.data() + begin_[to]);
      std::int32_t* end = found.room_for(each.size());
      for (const Sphere& sphere : each) {
        const Point gap = sphere.position - other.position;
        const double reach = sphere.half_radius + other.half_radius;
        // Without branches, which would be hard to predict. Other columns may have the same slots.
        *end = sphere.number;
        end += (dot(gap, gap) < reach * reach) & (sphere.column == column) & (sphere.number > after) &
               (sphere.number < limit);
      }
      found.set_end(end);
    };
    const std::size_t slot = slot_of(lowest);
    if (const std::size_t end = slot + n; end <= mask_ + 1) {
      scan_slots(slot, end);
    } else {
      scan_slots(slot, mask_ + 1);
      scan_slots(0, end - mask_ - 1);
    }
  }

  Point origin_;
  double width_;
  double largest_ = 0;                ///< radius
  std::size_t mask_;                  ///< number of slots - 1
  std::vector<std::uint32_t> begin_;  ///< by slot
  std::vector<Sphere> spheres_;       ///< by slot
};

}  // namespace

NearPairs near_pairs(std::span<const Point> points, std::span<const double> radius, std::size_t n_movable,
                     std::size_t begin, std::size_t end) {
  NearPairs pairs;
  pairs.first.assign(end - begin + 1, 0);
  if (begin == end) return pairs;
  const auto [finest, largest] = std::ranges::minmax(radius);
  Box bounds = nowhere;
  for (const Point& p : points) bounds.include(p);
  Box near = nowhere;
  for (std::size_t i = begin; i < end; ++i) near.include(points[i]);
  near.lower = near.lower - Point{largest, largest, largest};
  near.upper = near.upper + Point{largest, largest, largest};
  std::vector<std::vector<std::int32_t>> members;  // by level, which is that of the cells of twice the width
  std::vector<std::uint8_t> level(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (double width = finest; width < radius[i]; width *= 2) ++level[i];
    if (level[i] >= members.size()) members.resize(level[i] + std::size_t{1});
    if (near.contains(points[i])) members[level[i]].push_back(static_cast<std::int32_t>(i));
  }
  std::vector<Cells> levels;
  double width = finest;
  for (const auto& each : members) {
    // Two cells more on each side, so that no cell has a negative number.
    levels.emplace_back(bounds.lower - Point{2 * width, 2 * width, 2 * width}, width, each.size());
    levels.back().fill(points, radius, each);
    width *= 2;
  }
  pairs.other.resize(12 * (end - begin));
  Found found{pairs.other};
  for (std::size_t i = begin; i < end; ++i) {
    const Sphere own{points[i], radius[i] / 2, 0, static_cast<std::int32_t>(i)};
    const std::size_t limit = i < n_movable ? points.size() : n_movable;
    // A pair of different levels is found from the finer one, at whose side the cells are wide enough.
    for (std::size_t l = level[i]; l < levels.size(); ++l)
      levels[l].find_around(own, l == level[i], static_cast<std::int32_t>(limit), found);
    pairs.first[i - begin + 1] = found.n;
  }
  pairs.other.resize(found.n);
  return pairs;
}

}  // namespace crackle::geometry
