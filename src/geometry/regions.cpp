// SPDX-License-Identifier: GPL-3.0-or-later
#include "regions.h"

#include "common/index.h"

#include "plate.h"
#include "tolerances.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

namespace crackle::geometry {

namespace {

using Layout = plane::MaterialLayout;
using Line = Layout::Line;

/// Finds the material at a point.
class Materials {
public:
  Materials(const Layout& layout, double tolerance)
      : levels_(layout.levels), fills_(layout.fills), material_(layout.material) {
    for (const plane::Polygon& region : layout.region)
      outlines_.push_back(
          {plane::bounds_of(region),
           plane::SideIndex({{{region, std::vector<int>(region.size(), 0)}}, {}}, tolerance)});
  }

  int operator()(const Point& p) const {
    std::size_t layer = 0;
    while (layer + 2 < levels_.size() && p[0] > levels_[layer + 1]) ++layer;
    const plane::Point place = in_plane(p);
    for (std::size_t region = outlines_.size(); region-- > 0;) {
      const auto& [bounds, sides] = outlines_[region];
      if (!fills_[layer][region] || place[0] < bounds.lower[0] || place[0] > bounds.upper[0] ||
          place[1] < bounds.lower[1] || place[1] > bounds.upper[1])
        continue;
      if (sides.contains(place)) return material_[region];
    }
    return 0;
  }

private:
  /// A region's outline, divided as the lines are.
  struct Outline {
    plane::Bounds bounds;
    plane::SideIndex sides;
  };

  std::vector<double> levels_;
  std::vector<std::vector<std::uint8_t>> fills_;
  std::vector<int> material_;
  std::vector<Outline> outlines_;
};

/// Distance of a point along an edge [m], if it lies between its ends.
std::optional<double> arc_length_on(const Edge& edge, const Point& p, double near) {
  const double arc_length = dot(p - edge.from(), edge.direction());
  if (!(arc_length > near && arc_length < edge.length() - near)) return {};
  if (norm(p - edge.at(arc_length)) > near) return {};
  return arc_length;
}

class Dividing {
public:
  Dividing(Complex& complex, const Layout& layout, int n_plate_corners)
      : complex_(complex),
        layout_(layout),
        n_plate_(n_plate_corners),
        tolerance_(wall_tolerance * std::ranges::max(complex.bounds.upper - complex.bounds.lower)) {}

  void run() {
    add_walls();
    add_caps();
    add_volumes();
    add_edges();
  }

private:
  void add_walls() {
    for (std::size_t layer = 0; layer < layout_.n_layers(); ++layer)
      for (const Line& line : layout_.lines)
        if (layout_.is_wall(line, layer))
          complex_.inner_faces.push_back(
              wall(side_of(layout_, line), layout_.levels[layer], layout_.levels[layer + 1], {}));
  }

  void add_caps() {
    for (std::size_t level = 1; level < layout_.n_layers(); ++level) {
      std::vector<std::array<plane::Point, 2>> rim;
      Box domain = nowhere;
      for (const Line& line : layout_.lines) {
        const bool left = is_in_cap(layout_, line, level, true);
        const bool right = is_in_cap(layout_, line, level, false);
        const plane::Side side = side_of(layout_, line);
        if (left != right) rim.push_back({side.from, side.to});
        if (left || right)
          for (const plane::Point& p : {side.from, side.to}) domain.include(at(layout_.levels[level], p));
      }
      const double area = layout_.area(
          [&](const Line& line, bool on_left) { return is_in_cap(layout_, line, level, on_left); });
      complex_.inner_faces.push_back({{}, area, Vector{1, 0, 0}, Patch{domain}, std::move(rim)});
    }
  }

  void add_volumes() {
    int n_materials = 1;
    for (const int material : layout_.material) n_materials = std::max(n_materials, material + 1);
    complex_.material_volumes.assign(index(n_materials), 0);
    for (std::size_t layer = 0; layer < layout_.n_layers(); ++layer)
      for (int material = 0; material < n_materials; ++material)
        complex_.material_volumes[index(material)] +=
            (layout_.levels[layer + 1] - layout_.levels[layer]) *
            layout_.area([&](const Line& line, bool on_left) {
              return layout_.material_of(Layout::region_beside(line, on_left, layer)) == material;
            });
  }

  /// The edges of inner faces, and those of the plate divided at their ends.
  void add_edges() {
    std::set<std::pair<std::size_t, std::size_t>> lines;  // line and level
    std::set<std::pair<int, std::size_t>> along_x;        // corner and layer
    for (std::size_t i = 0; i < layout_.lines.size(); ++i) {
      const Line& line = layout_.lines[i];
      for (std::size_t layer = 0; layer < layout_.n_layers(); ++layer) {
        if (!layout_.is_wall(line, layer)) continue;
        for (const int end : line.end)
          if (end >= n_plate_) along_x.insert({end, layer});
        for (const std::size_t level : {layer, layer + 1}) lines.insert({i, level});
      }
      for (std::size_t level = 1; level < layout_.n_layers(); ++level)
        if (line.side >= 0 && is_in_cap(layout_, line, level, true)) lines.insert({i, level});
    }
    for (const auto& [i, level] : lines)
      for (const int end : layout_.lines[i].end) add_corner(end, level);
    for (const auto& [corner, layer] : along_x)
      for (const std::size_t level : {layer, layer + 1}) add_corner(corner, level);
    for (const auto& [key, p] : corners_) complex_.corners.push_back(p);
    for (const Edge& edge : std::exchange(complex_.edges, {})) add_divided(edge);
    for (const auto& [i, level] : lines)
      complex_.edges.emplace_back(place(layout_.lines[i].end[0], level),
                                  place(layout_.lines[i].end[1], level));
    for (const auto& [corner, layer] : along_x)
      complex_.edges.emplace_back(place(corner, layer), place(corner, layer + 1));
  }

  Point place(int corner, std::size_t level) const {
    return at(layout_.levels[level], layout_.corners[index(corner)]);
  }

  /// A corner that the plate has not.
  void add_corner(int corner, std::size_t level) {
    if (corner >= n_plate_ || (level > 0 && level < layout_.n_layers()))
      corners_.emplace(std::pair(corner, level), place(corner, level));
  }

  /// An edge of the plate, divided at the corners on it.
  void add_divided(const Edge& edge) {
    std::map<double, Point> arc_lengths;
    for (const auto& [key, p] : corners_)
      if (const auto arc_length = arc_length_on(edge, p, tolerance_)) arc_lengths.emplace(*arc_length, p);
    Point from = edge.from();
    for (const auto& [arc_length, p] : arc_lengths) {
      complex_.edges.emplace_back(from, p);
      from = p;
    }
    complex_.edges.emplace_back(from, edge.to());
  }

  Complex& complex_;
  const Layout& layout_;
  int n_plate_;
  double tolerance_;
  std::map<std::pair<int, std::size_t>, Point> corners_;
};

}  // namespace

bool is_in_cap(const Layout& layout, const Line& line, std::size_t level, bool on_left) {
  const auto material = [&](std::size_t layer) {
    return layout.material_of(Layout::region_beside(line, on_left, layer));
  };
  return (on_left || line.side < 0) && material(level - 1) != material(level);
}

plane::Side side_of(const Layout& layout, const Line& line) {
  return plane::side_between(layout.corners[index(line.end[0])], layout.corners[index(line.end[1])], -1);
}

void divide(Complex& complex, const plane::Specimen& specimen, std::vector<std::array<int, 2>> interfaces) {
  const Layout layout = plane::material_layout(specimen);
  Dividing(complex, layout, static_cast<int>(complex.corners.size() / 2)).run();
  complex.interfaces = std::move(interfaces);
  complex.material =
      [materials = std::make_shared<const Materials>(
           layout, wall_tolerance * std::ranges::max(complex.bounds.upper - complex.bounds.lower))](
          const Point& p) { return (*materials)(p); };
  complex.spacing_rules.push_back(region_spacing(specimen, layout));
}

}  // namespace crackle::geometry
