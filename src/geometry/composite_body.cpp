// SPDX-License-Identifier: GPL-3.0-or-later
// Inner faces, edges and corners of a body of several materials.
#include "composite_body.h"

#include "crackle/common/index.h"

#include "plane_directions.h"
#include "reflection.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace crackle::geometry {

namespace {

using Line = input::MaterialLayout::Line;

/// Way of a point along an edge [m], if it lies between its ends.
std::optional<double> arc_length_on(const Edge& edge, const Point& p, double near) {
  const Vector along = (edge.to() - edge.from()) / edge.length();
  const double arc_length = dot(p - edge.from(), along);
  if (!(arc_length > near && arc_length < edge.length() - near)) return {};
  const Vector gap = p - edge.at(arc_length);
  if (dot(gap, gap) > near * near) return {};
  return arc_length;
}

}  // namespace

/// Collects the edges at inner faces, as corners and lines of the layout.
class CompositeBody::Edges {
public:
  explicit Edges(CompositeBody& body)
      : body_(body), layout_(body.layout_), n_plate_(static_cast<int>(body.plate_sides_.size())) {
    for (const Line& line : layout_.lines)
      if (line.side >= 0)
        for (const int end : line.end) sides_at_[end].insert(line.side);
    for (std::size_t i = 0; i < layout_.lines.size(); ++i) {
      for (std::size_t layer = 0; layer < layout_.n_layers(); ++layer)
        if (layout_.is_wall(layout_.lines[i], layer)) add_wall(i, layer);
      for (std::size_t level = 1; level < layout_.n_layers(); ++level)
        if (layout_.lines[i].side >= 0 && body_.is_in_cap(layout_.lines[i], level, true))
          lines_.insert({i, level});
    }
  }

  void finish() {
    for (const auto& [i, level] : lines_)
      for (const int end : layout_.lines[i].end) add_corner(end, level);
    for (const auto& [corner, layer] : along_x_)
      for (const std::size_t level : {layer, layer + 1}) add_corner(corner, level);
    body_.shape_.corners = body_.plain_->corners();
    for (const auto& [key, p] : corners_) body_.shape_.corners.push_back(p);
    for (const Edge& edge : body_.plain_->edges()) add_divided(edge);
    body_.on_side_.resize(body_.plate_sides_.size());
    for (const auto& [i, level] : lines_) add_across(layout_.lines[i], level);
    for (const auto& [corner, layer] : along_x_) add_along_x(corner, layer);
  }

private:
  void add_wall(std::size_t line, std::size_t layer) {
    for (const int end : layout_.lines[line].end)
      if (end >= n_plate_) along_x_.insert({end, layer});
    for (const std::size_t level : {layer, layer + 1}) lines_.insert({line, level});
  }

  Point place(int corner, std::size_t level) const {
    return at(layout_.levels[level], layout_.corners[index(corner)]);
  }

  /// A corner that the plain body has not.
  void add_corner(int corner, std::size_t level) {
    if (corner >= n_plate_ || (level > 0 && level < layout_.n_layers()))
      corners_.emplace(std::pair(corner, level), place(corner, level));
  }

  /// An edge of the plain body, divided at the corners on it.
  void add_divided(const Edge& edge) {
    std::map<double, Point> arc_lengths;
    for (const auto& [key, p] : corners_)
      if (const auto arc_length = arc_length_on(edge, p, body_.tolerance_))
        arc_lengths.emplace(*arc_length, p);
    Point from = edge.from();
    for (const auto& [arc_length, p] : arc_lengths) {
      body_.shape_.edges.emplace_back(from, p);
      from = p;
    }
    if (arc_lengths.empty())
      body_.shape_.edges.push_back(edge);
    else
      body_.shape_.edges.emplace_back(from, edge.to());
  }

  void add_across(const Line& line, std::size_t level) {
    body_.shape_.edges.emplace_back(place(line.end[0], level), place(line.end[1], level));
    if (line.side < 0) return;
    const plane::Side& side = body_.plate_sides_[index(line.side)];
    const auto own = [&](int end) {
      return plane::Point{layout_.levels[level], side.arc_length(layout_.corners[index(end)])};
    };
    body_.on_side_[index(line.side)].push_back({own(line.end[0]), own(line.end[1])});
  }

  void add_along_x(int corner, std::size_t layer) {
    body_.shape_.edges.emplace_back(place(corner, layer), place(corner, layer + 1));
    const auto sides = sides_at_.find(corner);
    if (sides == sides_at_.end()) return;
    for (const int s : sides->second) {
      const double arc_length = body_.plate_sides_[index(s)].arc_length(layout_.corners[index(corner)]);
      body_.on_side_[index(s)].push_back({plane::Point{layout_.levels[layer], arc_length},
                                          plane::Point{layout_.levels[layer + 1], arc_length}});
    }
  }

  CompositeBody& body_;
  const input::MaterialLayout& layout_;
  int n_plate_;                                          ///< corners of the plate, as many as sides
  std::set<std::pair<std::size_t, std::size_t>> lines_;  ///< line and level
  std::set<std::pair<int, std::size_t>> along_x_;        ///< corner and layer
  std::map<std::pair<int, std::size_t>, Point> corners_;
  std::map<int, std::set<int>> sides_at_;  ///< of the plate, at corners
};

CompositeBody::CompositeBody(std::unique_ptr<const Body> plain, const input::Specimen& specimen,
                             std::vector<std::array<int, 2>> interfaces)
    : plain_(std::move(plain)),
      layout_(input::material_layout(specimen)),
      tolerance_(wall_tolerance * std::ranges::max(plain_->size())),
      plate_sides_(plane::sides_of(input::shape_of(specimen))) {
  shape_.bounds = plain_->bounds();
  shape_.volume = plain_->volume();
  shape_.faces = plain_->faces();
  shape_.crack_starts = plain_->crack_starts();
  shape_.outline = plain_->outline();
  shape_.interfaces = std::move(interfaces);
  plane_bounds_ = {{bounds().lower[1], bounds().lower[2]}, {bounds().upper[1], bounds().upper[2]}};
  for (const input::MaterialRegion& region : specimen.regions)
    is_curve_.push_back(region.shape && region.shape->polygon.empty());
  for (const plane::Polygon& region : layout_.region)
    outlines_.push_back({plane::bounds_of(region),
                         plane::SideIndex({{{region, std::vector<int>(region.size(), 0)}}, {}}, tolerance_)});
  add_walls();
  add_caps();
  add_volumes();
  Edges(*this).finish();
}

/// True if materials change at a level of x, beside a line.
bool CompositeBody::is_in_cap(const Line& line, std::size_t level, bool on_left) const {
  const auto material = [&](std::size_t layer) {
    return layout_.material_of(input::MaterialLayout::region_beside(line, on_left, layer));
  };
  return (on_left || line.side < 0) && material(level - 1) != material(level);
}

plane::Side CompositeBody::side_of(const Line& line, std::size_t number) const {
  return plane::side_between(layout_.corners[index(line.end[0])], layout_.corners[index(line.end[1])],
                             static_cast<int>(number));
}

void CompositeBody::add_walls() {
  for (std::size_t layer = 0; layer < layout_.n_layers(); ++layer) {
    const double lower = layout_.levels[layer];
    const double height = layout_.levels[layer + 1] - lower;
    std::vector<plane::Side> sides;
    Box around = nowhere;
    for (std::size_t i = 0; i < layout_.lines.size(); ++i) {
      if (!layout_.is_wall(layout_.lines[i], layer)) continue;
      const plane::Side side = side_of(layout_.lines[i], i);
      inner_.push_back({false, layer, sides.size()});
      sides.push_back(side);
      for (const plane::Point& p : {side.from, side.to})
        for (const double shift : {-tolerance_, tolerance_})
          for (const double x : {lower, layout_.levels[layer + 1]})
            around.include(at(x, {p[0] + shift, p[1] + shift}));
      const Patch patch{{{0, 0, 0}, {height, side.length, 0}},
                        at(lower, side.from),
                        {{{1, 0, 0}, {0, side.along[0], side.along[1]}, {0, -side.along[1], side.along[0]}}}};
      shape_.inner_faces.push_back(
          {{}, height * side.length, Vector{0, side.along[1], -side.along[0]}, patch});
    }
    layers_.push_back({lower, layout_.levels[layer + 1],
                       plane::SideIndex(std::move(sides), plane_bounds_, tolerance_), around});
  }
}

void CompositeBody::add_caps() {
  for (std::size_t level = 1; level < layout_.n_layers(); ++level) {
    std::vector<plane::Side> rim, borders;
    Box domain = nowhere;
    for (std::size_t i = 0; i < layout_.lines.size(); ++i) {
      const Line& line = layout_.lines[i];
      const bool left = is_in_cap(line, level, true);
      const bool right = is_in_cap(line, level, false);
      const plane::Side side = side_of(line, i);
      if (left != right) rim.push_back(side);
      if (left != right || (left && (layout_.is_wall(line, level - 1) || layout_.is_wall(line, level))))
        borders.push_back(side);
      if (left || right)
        for (const plane::Point& p : {side.from, side.to}) domain.include(at(layout_.levels[level], p));
    }
    const double area =
        layout_.area([&](const Line& line, bool on_left) { return is_in_cap(line, level, on_left); });
    shape_.inner_faces.push_back({{}, area, Vector{1, 0, 0}, Patch{domain}});
    inner_.push_back({true, caps_.size(), 0});
    caps_.push_back({layout_.levels[level], plane::SideIndex(std::move(rim), plane_bounds_, tolerance_),
                     plane::SideIndex(std::move(borders), plane_bounds_, tolerance_)});
  }
}

void CompositeBody::add_volumes() {
  int n_materials = 1;
  for (const int material : layout_.material) n_materials = std::max(n_materials, material + 1);
  shape_.material_volumes.assign(index(n_materials), 0);
  for (std::size_t layer = 0; layer < layout_.n_layers(); ++layer)
    for (int material = 0; material < n_materials; ++material)
      shape_.material_volumes[index(material)] +=
          (layout_.levels[layer + 1] - layout_.levels[layer]) *
          layout_.area([&](const Line& line, bool on_left) {
            return layout_.material_of(input::MaterialLayout::region_beside(line, on_left, layer)) ==
                   material;
          });
}

}  // namespace crackle::geometry
