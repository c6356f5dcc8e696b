// SPDX-License-Identifier: GPL-3.0-or-later
#include "plane/side_index.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::plane {

namespace {

constexpr double cells_per_side = 16;
constexpr double fewest_cells = 1024;  ///< but of a few sides, all in one
constexpr std::size_t few_sides = 4;
constexpr double most_cells = 1 << 18;

/// True if a segment intersects a square.
bool meets(const Side& side, const Point& centre, double half_size) {
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [low, high] = std::minmax(side.from[i], side.to[i]);
    if (low > centre[i] + half_size || high < centre[i] - half_size) return false;
  }
  return std::abs(side.height(centre)) <= half_size * (std::abs(side.along[0]) + std::abs(side.along[1]));
}

}  // namespace

Side side_between(const Point& from, const Point& to, int part) {
  const Point arc_length = to - from;
  const double length = norm(arc_length);
  // Divided, so that the vector of a side along an axis is one of +-1 and 0.
  return {from, to, {arc_length[0] / length, arc_length[1] / length}, length, part};
}

std::vector<Side> sides_of(const Shape& shape) {
  std::vector<Side> sides;
  for (const Loop& loop : shape.loops)
    for (std::size_t i = 0; i < loop.size(); ++i)
      sides.push_back(side_between(loop.from(i), loop.to(i), loop.part[i]));
  return sides;
}

SideIndex::SideIndex(const Shape& shape, double tolerance)
    : SideIndex(sides_of(shape), bounds_of(shape.loops.front().corners), tolerance) {}

SideIndex::SideIndex(std::vector<Side> sides, const Bounds& bounds, double tolerance)
    : sides_(std::move(sides)), tolerance_(tolerance), bounds_(bounds) {
  const Point size = bounds_.upper - bounds_.lower;
  const double n_cells =
      sides_.size() <= few_sides
          ? 1
          : std::clamp(cells_per_side * static_cast<double>(sides_.size()), fewest_cells, most_cells);
  cell_size_ = std::sqrt(size[0] * size[1] / n_cells);
  for (std::size_t i = 0; i < 2; ++i)
    n_[i] = static_cast<std::size_t>(std::clamp(std::ceil(size[i] / cell_size_), 1.0, n_cells));
  cell_size_ = std::max(size[0] / static_cast<double>(n_[0]), size[1] / static_cast<double>(n_[1]));

  of_row_.resize(n_[1]);
  for (std::size_t s = 0; s < sides_.size(); ++s) {
    const auto [low, high] = std::minmax(sides_[s].from[1], sides_[s].to[1]);
    const std::size_t last = cell_of({bounds_.lower[0], high + tolerance}).row;
    for (std::size_t row = cell_of({bounds_.lower[0], low - tolerance}).row; row <= last; ++row)
      of_row_[row].push_back(static_cast<std::int32_t>(s));
  }
  const double half_size = cell_size_ / 2 * (1 + 1e-9) + tolerance;
  first_.push_back(0);
  for (std::size_t row = 0; row < n_[1]; ++row)
    for (std::size_t column = 0; column < n_[0]; ++column) {
      const Point centre = bounds_.lower + Point{(static_cast<double>(column) + 0.5) * cell_size_,
                                                 (static_cast<double>(row) + 0.5) * cell_size_};
      for (const std::int32_t s : of_row_[row])
        if (meets(sides_[static_cast<std::size_t>(s)], centre, half_size)) of_cell_.push_back(s);
      const bool is_empty = of_cell_.size() == first_.back();
      first_.push_back(of_cell_.size());
      is_inside_.push_back(is_empty && contains_open(centre));
    }
}

SideIndex::Cell SideIndex::cell_of(const Point& p) const {
  const auto clamped = [&](std::size_t i) {
    const double cell = (p[i] - bounds_.lower[i]) / cell_size_;
    return static_cast<std::size_t>(std::clamp(cell, 0.0, static_cast<double>(n_[i] - 1)));
  };
  return {clamped(0), clamped(1)};
}

/// Undefined on a side.
bool SideIndex::contains_open(const Point& p) const {
  bool inside = false;
  for (const std::int32_t s : of_row_[cell_of(p).row]) {
    const Side& side = sides_[static_cast<std::size_t>(s)];
    if (ray_meets(p, side.from, side.to)) inside = !inside;
  }
  return inside;
}

bool SideIndex::contains(const Point& p) const {
  for (std::size_t i = 0; i < 2; ++i)
    if (p[i] < bounds_.lower[i] - tolerance_ || p[i] > bounds_.upper[i] + tolerance_) return false;
  const Cell cell = cell_of(p);
  const std::span<const std::int32_t> near = sides_in(cell);
  if (near.empty()) return is_inside_[cell.row * n_[0] + cell.column];
  for (const std::int32_t s : near)
    if (is_on(sides_[static_cast<std::size_t>(s)], p)) return true;
  return contains_open(p);
}

double SideIndex::distance(const Point& p, double limit) const {
  if (sides_.empty()) return infinity;
  const Cell cell = cell_of(p);
  double nearest = infinity;
  const auto search = [&](std::size_t column, std::size_t row) {
    for (const std::int32_t s : sides_in({column, row})) {
      const Side& side = sides_[static_cast<std::size_t>(s)];
      nearest = std::min(nearest, plane::distance(p, side.from, side.to));
    }
  };
  // Search rings of cells until those farther out cannot be closer.
  const std::size_t most = std::max(n_[0], n_[1]);
  for (std::size_t ring = 0; ring <= most; ++ring) {
    if (ring > 0 && std::min(nearest, limit) <= (static_cast<double>(ring) - 1) * cell_size_) break;
    const std::size_t top = cell.row + ring;
    const std::size_t right = cell.column + ring;
    const std::size_t left = cell.column >= ring ? cell.column - ring : 0;
    const std::size_t bottom = cell.row >= ring ? cell.row - ring : 0;
    for (std::size_t row = bottom; row <= std::min(top, n_[1] - 1); ++row) {
      const bool is_end = row == top || (cell.row >= ring && row == bottom);
      if (is_end) {
        for (std::size_t column = left; column <= std::min(right, n_[0] - 1); ++column) search(column, row);
        continue;
      }
      if (cell.column >= ring) search(left, row);
      if (right < n_[0] && ring > 0) search(right, row);
    }
  }
  return nearest;
}

Cover SideIndex::cover(const std::array<Point, 4>& points) const {
  return cover_of(std::span<const Point, 4>(points));
}

Cover SideIndex::cover(std::span<const Point> points) const {
  return cover_of(points);
}

template <std::size_t extent>
Cover SideIndex::cover_of(std::span<const Point, extent> points) const {
  Point lower = points[0];
  Point upper = points[0];
  Point centre{};
  for (const Point& p : points)
    for (std::size_t i = 0; i < 2; ++i) {
      lower[i] = std::min(lower[i], p[i]);
      upper[i] = std::max(upper[i], p[i]);
      centre[i] += p[i] / static_cast<double>(points.size());
    }
  const Cell low = cell_of(lower);
  const Cell high = cell_of(upper);
  bool is_flat = false;
  std::array<double, 8> height{};
  for (std::size_t row = low.row; row <= high.row; ++row)
    for (std::size_t column = low.column; column <= high.column; ++column)
      for (const std::int32_t s : sides_in({column, row})) {
        const Side& side = sides_[static_cast<std::size_t>(s)];
        int n_left = 0;
        int n_right = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
          height[i] = side.height(points[i]);
          n_left += height[i] > tolerance_;
          n_right += height[i] < -tolerance_;
        }
        is_flat = is_flat || (n_left == 0 && n_right == 0);
        if (n_left == 0 || n_right == 0) continue;
        // The part of the side's line in the hull, as an interval along the line.
        double from = infinity;
        double to = -infinity;
        const auto include = [&](double arc_length) {
          from = std::min(from, arc_length);
          to = std::max(to, arc_length);
        };
        for (std::size_t i = 0; i < points.size(); ++i) {
          const double arc_length = side.arc_length(points[i]);
          if (std::abs(height[i]) <= tolerance_) include(arc_length);
          for (std::size_t j = 0; j < i; ++j)
            if ((height[i] > tolerance_ && height[j] < -tolerance_) ||
                (height[j] > tolerance_ && height[i] < -tolerance_))
              include(arc_length +
                      (side.arc_length(points[j]) - arc_length) * (height[i] / (height[i] - height[j])));
        }
        if (std::min(to, side.length) - std::max(from, 0.0) > tolerance_) return Cover::crossing;
      }
  if (is_flat) return Cover::outside;
  const Cell cell = cell_of(centre);
  const bool inside =
      sides_in(cell).empty() ? is_inside_[cell.row * n_[0] + cell.column] : contains_open(centre);
  return inside ? Cover::inside : Cover::outside;
}

}  // namespace crackle::plane
