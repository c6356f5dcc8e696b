// SPDX-License-Identifier: GPL-3.0-or-later
#include "plane/subdivision.h"

#include "common/index.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace crackle::plane {

namespace {

/// Dividing lines at the corners on them moves them by less than the tolerance, so that few rounds find more.
constexpr int most_rounds = 50;

/// A line of corners: a side of the plate, or a closed outline whose first corner is repeated.
using Path = std::vector<int>;

/// The point of a segment nearest to p, with the exact coordinate of a segment along an axis.
Point nearest_on(const Point& from, const Point& to, const Point& p) {
  const Point along = to - from;
  Point result = from + std::clamp(dot(p - from, along) / dot(along, along), 0.0, 1.0) * along;
  for (std::size_t i = 0; i < 2; ++i)
    if (from[i] == to[i]) result[i] = from[i];
  return result;
}

/// Where the interiors of two segments cross.
std::optional<Point> crossing(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point along = b - a;
  const Point other = d - c;
  const double slope = cross(along, other);
  if (slope == 0) return {};
  const double share = cross(c - a, other) / slope;
  const double other_share = cross(c - a, along) / slope;
  if (!(share > 0 && share < 1 && other_share > 0 && other_share < 1)) return {};
  Point result = a + share * along;
  for (std::size_t i = 0; i < 2; ++i) {
    if (c[i] == d[i]) result[i] = c[i];
    if (a[i] == b[i]) result[i] = a[i];
  }
  return result;
}

class Subdividing {
public:
  Subdividing(const Shape& plate, const std::vector<Polygon>& figures, double tolerance)
      : plate_(plate), tolerance_(tolerance) {
    for (const Loop& loop : plate.loops) {
      const int first = static_cast<int>(corners_.size());
      const int n = static_cast<int>(loop.size());
      corners_.insert(corners_.end(), loop.corners.begin(), loop.corners.end());
      for (int i = 0; i < n; ++i) paths_.push_back({first + i, first + (i + 1) % n});
    }
    n_sides_ = paths_.size();
    for (const Polygon& figure : figures) {
      Path path;
      for (const Point& p : figure) path.push_back(corner(p));
      path.push_back(path.front());
      paths_.push_back(std::move(path));
    }
    for (int round = 0; divide(); ++round)
      if (round == most_rounds) throw std::runtime_error("lines that nearly coincide cannot be told apart");
  }

  Subdivision result() {
    Subdivision result;
    for (std::size_t f = n_sides_; f < paths_.size(); ++f) {
      Polygon& outline = result.figures.emplace_back();
      for (std::size_t i = 0; i + 1 < paths_[f].size(); ++i) outline.push_back(corners_[index(paths_[f][i])]);
    }
    for (const auto& [ends, runs] : lines()) add_line(ends, runs, result);
    result.corners = std::move(corners_);
    return result;
  }

private:
  /// How paths run along a line, from its lower corner to its higher one or back.
  struct Runs {
    std::optional<std::pair<int, bool>> side;  ///< of the plate, and whether it runs back
    std::map<int, int> net;                    ///< per figure, how much more often forth than back
  };

  /// The corner at a point, with those closer than the tolerance merged.
  int corner(Point p) {
    if (const auto known = corner_near(p)) return *known;
    for (std::size_t s = 0; s < n_sides_; ++s) {
      const Point& from = corners_[index(paths_[s].front())];
      const Point& to = corners_[index(paths_[s].back())];
      const Point nearest = nearest_on(from, to, p);
      if (norm(nearest - p) > tolerance_) continue;
      p = nearest;
      if (const auto known = corner_near(p)) return *known;
      break;
    }
    corners_.push_back(p);
    return static_cast<int>(corners_.size()) - 1;
  }

  std::optional<int> corner_near(const Point& p) const {
    for (std::size_t i = 0; i < corners_.size(); ++i)
      if (std::abs(corners_[i][0] - p[0]) <= tolerance_ && norm(corners_[i] - p) <= tolerance_)
        return static_cast<int>(i);
    return {};
  }

  /// A piece of paths, with its bounding box.
  struct Piece {
    std::array<int, 2> end;  ///< ascending
    Bounds bounds;
  };

  std::vector<Piece> pieces() const {
    std::set<std::array<int, 2>> known;
    std::vector<Piece> result;
    for (const Path& path : paths_)
      for (std::size_t i = 1; i < path.size(); ++i) {
        const auto [low, high] = std::minmax(path[i - 1], path[i]);
        if (low == high || !known.insert({low, high}).second) continue;
        result.push_back({{low, high}, bounds_of({corners_[index(low)], corners_[index(high)]})});
      }
    std::ranges::sort(result, {},
                      [](const Piece& piece) { return std::pair(piece.bounds.lower[1], piece.end); });
    return result;
  }

  /// Divides pieces where they meet others. @return false if none does
  bool divide() {
    cuts_.clear();
    const std::vector<Piece> all = pieces();
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = i + 1; j < all.size(); ++j) {
        const Bounds& a = all[i].bounds;
        const Bounds& b = all[j].bounds;
        if (b.lower[1] > a.upper[1] + tolerance_) break;
        if (a.lower[0] > b.upper[0] + tolerance_ || b.lower[0] > a.upper[0] + tolerance_) continue;
        cut(all[i].end, all[j].end);
      }
    if (cuts_.empty()) return false;
    for (Path& path : paths_) path = divided(path);
    return true;
  }

  void cut(const std::array<int, 2>& a, const std::array<int, 2>& b) {
    const bool a_is_cut = cut_at_ends(a, b), b_is_cut = cut_at_ends(b, a);
    if (a_is_cut || b_is_cut || a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]) return;
    const auto p =
        crossing(corners_[index(a[0])], corners_[index(a[1])], corners_[index(b[0])], corners_[index(b[1])]);
    if (!p) return;
    const int number = corner(*p);
    for (const auto& ends : {a, b})
      if (number != ends[0] && number != ends[1]) cuts_[ends].insert(number);
  }

  bool cut_at_ends(const std::array<int, 2>& piece, const std::array<int, 2>& other) {
    bool touches = false;
    for (const int end : other) {
      if (end == piece[0] || end == piece[1]) continue;
      if (distance(corners_[index(end)], corners_[index(piece[0])], corners_[index(piece[1])]) > tolerance_)
        continue;
      cuts_[piece].insert(end);
      touches = true;
    }
    return touches;
  }

  Path divided(const Path& path) const {
    Path result{path.front()};
    for (std::size_t i = 1; i < path.size(); ++i) {
      const int from = path[i - 1];
      const int to = path[i];
      if (from == to) continue;
      if (const auto found = cuts_.find({std::min(from, to), std::max(from, to)}); found != cuts_.end()) {
        Path between(found->second.begin(), found->second.end());
        const Point& start = corners_[index(from)];
        const Point arc_length = corners_[index(to)] - start;
        std::ranges::sort(between, {},
                          [&](int number) { return dot(corners_[index(number)] - start, arc_length); });
        result.insert(result.end(), between.begin(), between.end());
      }
      result.push_back(to);
    }
    return result;
  }

  std::map<std::array<int, 2>, Runs> lines() const {
    std::map<std::array<int, 2>, Runs> result;
    for (std::size_t i = 0; i < paths_.size(); ++i)
      for (std::size_t k = 1; k < paths_[i].size(); ++k) {
        const int from = paths_[i][k - 1];
        const int to = paths_[i][k];
        if (from == to) continue;
        Runs& runs = result[{std::min(from, to), std::max(from, to)}];
        if (i < n_sides_)
          runs.side = {static_cast<int>(i), from > to};
        else
          runs.net[static_cast<int>(i - n_sides_)] += from < to ? 1 : -1;
      }
    return result;
  }

  void add_line(std::array<int, 2> ends, const Runs& runs, Subdivision& result) const {
    const Point middle = 0.5 * (corners_[index(ends[0])] + corners_[index(ends[1])]);
    if (!runs.side && !is_in_plate(middle)) return;
    Subdivision::Line line{ends, runs.side ? runs.side->first : -1, {}, {}};
    for (int f = 0; f < static_cast<int>(result.figures.size()); ++f) {
      const auto net = runs.net.find(f);
      const bool is_outline = net != runs.net.end() && net->second != 0;
      const bool is_inside = !is_outline && holds(result.figures[index(f)], middle);
      if (is_outline ? net->second > 0 : is_inside) line.left.push_back(f);
      if (is_outline ? net->second < 0 : is_inside) line.right.push_back(f);
    }
    if (runs.side && runs.side->second) {
      std::swap(line.end[0], line.end[1]);
      std::swap(line.left, line.right);
    }
    if (runs.side) line.right.clear();
    result.lines.push_back(std::move(line));
  }

  bool is_in_plate(const Point& p) const {
    return holds(plate_.loops.front().corners, p) &&
           std::none_of(plate_.loops.begin() + 1, plate_.loops.end(),
                        [&](const Loop& hole) { return holds(hole.corners, p); });
  }

  const Shape& plate_;
  double tolerance_;
  std::vector<Point> corners_;
  std::vector<Path> paths_;  ///< the sides of the plate, then the figures
  std::size_t n_sides_ = 0;
  std::map<std::array<int, 2>, std::set<int>> cuts_;  ///< corners on pieces
};

}  // namespace

Subdivision subdivide(const Shape& plate, const std::vector<Polygon>& figures, double tolerance) {
  return Subdividing(plate, figures, tolerance).result();
}

}  // namespace crackle::plane
