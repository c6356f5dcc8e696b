// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/failure.h"
#include "common/index.h"
#include "common/printable.h"
#include "common/quantity_text.h"
#include "common/vector.h"
#include "geometry/mother_points.h"

#include <fmt/format.h>
#include <nanoflann.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>

namespace crackle::geometry {

namespace {

/// A k-d tree over fixed points, for queries by radius.
class PointTree {
public:
  /// Keeps a view of `points`.
  explicit PointTree(std::span<const Point> points) : cloud_{points}, tree_(3, cloud_) {}

  /// Sets `found` to the numbers of the points closer than `radius` to p, ascending.
  void find(const Point& p, double radius, std::vector<std::int32_t>& found) const {
    found.clear();
    Closer closer{radius * radius, found};
    tree_.findNeighbors(closer, p.data(), {});
    std::sort(found.begin(), found.end());
  }

private:
  struct Cloud {
    std::span<const Point> points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
    bool kdtree_get_bbox(auto&) const { return false; }
  };

  /// Collects the points whose squared distance is below a limit. The tree rounds the distances of the
  /// branches that it skips, so it searches a little farther.
  struct Closer {
    double limit;
    std::vector<std::int32_t>& found;
    bool addPoint(double distance, std::int32_t i) {
      if (distance < limit) found.push_back(i);
      return true;
    }
    double worstDist() const { return limit * (1 + 1e-9); }
    bool full() const { return true; }
    std::size_t size() const { return found.size(); }
    void sort() const {}
  };

  Cloud cloud_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3, std::int32_t>
      tree_;
};

constexpr double metres_per_unit = 1e-3;
constexpr double snap_tolerance = 1e-9;  // relative to the body's largest size
constexpr std::size_t max_messages = 20;

/// The next blank-separated word of `line`, which is removed from it.
std::string_view next_word(std::string_view& line) {
  const char* const blanks = " \t\r,";
  line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(blanks));
  line.remove_prefix(word.size());
  return word;
}

std::optional<double> number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

class Messages {
public:
  explicit Messages(const std::filesystem::path& file) : file_(file.string()) {}
  void add(std::size_t line, const std::string& reason) {
    if (n_++ < max_messages)
      text_ += fmt::format("{}{}:{}: {}", text_.empty() ? "" : "\n", file_, line, reason);
  }
  void throw_if_any() const {
    if (n_ == 0) return;
    throw std::runtime_error(n_ <= max_messages ? text_
                                                : fmt::format("{}\n{}: {}", text_, file_,
                                                              count_text(n_ - max_messages, "more error")));
  }

private:
  std::string file_;
  std::string text_;
  std::size_t n_ = 0;
};

}  // namespace

std::vector<Point> read_points(const std::filesystem::path& file, const Body& body) {
  std::ifstream stream(file);
  if (!stream) fail("{}: cannot be read", file.string());
  const Point size = body.size();
  const double tolerance = snap_tolerance * *std::ranges::max_element(size);
  Messages messages(file);
  std::vector<Point> points;
  std::vector<std::size_t> lines;
  std::string text;
  for (std::size_t line = 1; std::getline(stream, text); ++line) {
    std::string_view rest = std::string_view(text).substr(0, text.find('#'));
    if (line == 1) rest = without_mark(rest);
    std::string_view word = next_word(rest);
    if (word.empty()) continue;
    Point p{};
    bool valid = true;
    for (double& coordinate : p) {
      const std::optional<double> value = number(word);
      valid = valid && value;
      coordinate = value.value_or(0) * metres_per_unit;
      word = next_word(rest);
    }
    if (!valid || !word.empty()) {
      messages.add(line, "not a point; give three numbers \"x y z\" in millimetres");
      continue;
    }
    p = body.snapped(p, tolerance);
    if (!body.contains(p)) {
      messages.add(line, fmt::format("the point ({:g}, {:g}, {:g}) mm lies outside the body",
                                     p[0] / metres_per_unit, p[1] / metres_per_unit, p[2] / metres_per_unit));
      continue;
    }
    points.push_back(p);
    lines.push_back(line);
  }
  if (stream.bad()) fail("{}: cannot be read to the end", file.string());

  const PointTree tree(points);
  std::vector<std::int32_t> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    tree.find(points[i], tolerance, near);
    if (static_cast<std::size_t>(near.front()) < i)
      messages.add(lines[i], fmt::format("the same point as in line {}", lines[index(near.front())]));
  }
  messages.throw_if_any();

  for (const Point& corner : body.corners()) {
    tree.find(corner, tolerance, near);
    if (near.empty())
      fail("{}: the corner ({:g}, {:g}, {:g}) mm of the body is not among the points", file.string(),
           corner[0] / metres_per_unit, corner[1] / metres_per_unit, corner[2] / metres_per_unit);
  }
  return points;
}

}  // namespace crackle::geometry
