// SPDX-License-Identifier: GPL-3.0-or-later
// Location of points and tetrahedra in a body of several materials.
#include "composite_body.h"

#include "crackle/common/index.h"
#include "crackle/common/real.h"

#include "plane_directions.h"

#include <algorithm>
#include <cmath>

namespace crackle::geometry {

namespace {

constexpr std::size_t first_wall = 2;  ///< face of side 0 of the plate

/// Sides that meet at a smaller angle continue each other [rad].
constexpr double straight = 1e-9;

bool continues(const plane::Side& a, const plane::Side& b) {
  return std::abs(plane::cross(a.along, b.along)) <= straight;
}

/// The point of a side at a distance from its start, which is that of an end without rounding.
plane::Point place_on(const plane::Side& side, double arc_length) {
  if (arc_length <= 0) return side.from;
  if (arc_length >= side.length) return side.to;
  return {side.from[0] + arc_length * side.along[0], side.from[1] + arc_length * side.along[1]};
}

bool interiors_meet(const Box& a, const Box& b) {
  for (std::size_t i = 0; i < 3; ++i)
    if (a.lower[i] >= b.upper[i] || b.lower[i] >= a.upper[i]) return false;
  return true;
}

/// Points that span a part of a tetrahedron, in the plane of the plate.
struct Span {
  std::array<plane::Point, 8> point;
  std::size_t n = 0;

  void add(const plane::Point& p) {
    if (n < point.size()) point[n++] = p;
  }
  std::span<const plane::Point> points() const { return {point.data(), n}; }
};

/// Adds the points where the edges of a tetrahedron cross a level of x.
void add_section(const std::array<Point, 4>& corners, double x, Span& span) {
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double before = corners[i][0] - x;
      const double after = corners[j][0] - x;
      if (!((before < 0 && after > 0) || (before > 0 && after < 0))) continue;
      const double share = before / (before - after);
      span.add({corners[i][1] + share * (corners[j][1] - corners[i][1]),
                corners[i][2] + share * (corners[j][2] - corners[i][2])});
    }
}

}  // namespace

template <class Visit>
void CompositeBody::for_walls_at(const Point& p, Visit&& visit) const {
  for (const Layer& layer : layers_)
    if (layer.around.contains(p))
      layer.walls.for_sides_at(in_plane(p), [&](std::size_t i) { visit(layer.walls.sides()[i]); });
}

int CompositeBody::material_at(const Point& p) const {
  std::size_t layer = 0;
  while (layer + 1 < layers_.size() && p[0] > layers_[layer].upper) ++layer;
  const plane::Point place = in_plane(p);
  for (std::size_t region = outlines_.size(); region-- > 0;) {
    const Outline& outline = outlines_[region];
    if (!layout_.fills[layer][region] || place[0] < outline.bounds.lower[0] ||
        place[0] > outline.bounds.upper[0] || place[1] < outline.bounds.lower[1] ||
        place[1] > outline.bounds.upper[1])
      continue;
    if (outline.sides.contains(place)) return layout_.material[region];
  }
  return 0;
}

bool CompositeBody::in_face(FaceId face, const Point& p) const {
  const InnerFace* const own = inner(face);
  if (own == nullptr) return plain_->in_face(face, p);
  if (own->is_cap) return is_on_cap(caps_[own->number], p);
  const Layer& layer = layers_[own->number];
  return p[0] >= layer.lower && p[0] <= layer.upper && layer.walls.is_on(wall(*own), in_plane(p));
}

std::uint8_t CompositeBody::movable(const Point& p) const {
  unsigned movable = plain_->movable(p);
  const plane::Side* found = nullptr;
  bool is_bent = false;
  for_walls_at(p, [&](const plane::Side& side) {
    is_bent = is_bent || (found != nullptr && !continues(*found, side));
    found = &side;
  });
  if (found != nullptr) {
    const bool is_inside = (movable & ~along_x) == (along_y | along_z);
    movable = (movable & along_x) | (is_inside && !is_bent ? direction_of(*found) : 0u);
  }
  if ((movable & along_x) && std::ranges::any_of(caps_, [&](const Cap& cap) { return is_on_cap(cap, p); }))
    movable &= ~along_x;
  return static_cast<std::uint8_t>(movable);
}

Directions CompositeBody::directions(const Point& p, std::uint8_t movable) const {
  const plane::Side* found = nullptr;
  if (movable & along_wall)
    for_walls_at(p, [&](const plane::Side& side) {
      if (direction_of(side) == along_wall) found = &side;
    });
  if (found == nullptr) return plain_->directions(p, movable);
  Directions result{};
  if (movable & along_x) result.vector[index(result.n++)] = {1, 0, 0};
  result.vector[index(result.n++)] = {0, found->along[0], found->along[1]};
  return result;
}

double CompositeBody::distance_to_surface(const Point& p) const {
  double nearest = plain_->distance_to_surface(p);
  for (const Layer& layer : layers_) {
    const double gap = std::max({layer.lower - p[0], p[0] - layer.upper, 0.0});
    if (gap < nearest) nearest = std::min(nearest, std::hypot(gap, layer.walls.distance(in_plane(p))));
  }
  for (const Cap& cap : caps_) {
    const double gap = std::abs(p[0] - cap.x);
    if (gap >= nearest) continue;
    const bool is_over = cap.rim.contains(in_plane(p));
    nearest = std::min(nearest, is_over ? gap : std::hypot(gap, cap.rim.distance(in_plane(p))));
  }
  return nearest;
}

double CompositeBody::distance_to_outline(FaceId face, const Point& p) const {
  const plane::Point place = in_plane(p);
  if (const InnerFace* const own = inner(face)) {
    if (own->is_cap) {
      const Cap& cap = caps_[own->number];
      return cap.rim.contains(place) ? cap.borders.distance(place) : 0;
    }
    const Layer& layer = layers_[own->number];
    const plane::Side& side = wall(*own);
    const double arc_length = side.arc_length(place);
    return std::min({p[0] - layer.lower, layer.upper - p[0], arc_length, side.length - arc_length});
  }
  double nearest = plain_->distance_to_outline(face, p);
  if (index(face) < first_wall)
    return std::min(nearest, (face == 0 ? layers_.front() : layers_.back()).walls.distance(place));
  const std::size_t side = index(face) - first_wall;
  const plane::Point own{p[0], plate_sides_[side].arc_length(place)};
  for (const OwnLine& line : on_side_[side])
    nearest = std::min(nearest, plane::distance(own, line[0], line[1]));
  return nearest;
}

std::optional<Point> CompositeBody::passage(FaceId face, const Point& p, const Point& q,
                                            double margin) const {
  const InnerFace* const own = inner(face);
  if (own == nullptr) return plain_->passage(face, p, q, margin);
  return own->is_cap ? passage_of_cap(caps_[own->number], p, q, margin) : passage_of_wall(*own, p, q, margin);
}

std::optional<Point> CompositeBody::passage_of_wall(const InnerFace& face, const Point& p, const Point& q,
                                                    double margin) const {
  const Layer& layer = layers_[face.number];
  const plane::Side& side = wall(face);
  const double before = side.height(in_plane(p));
  const double after = side.height(in_plane(q));
  if (!((before < -tolerance_ && after > tolerance_) || (before > tolerance_ && after < -tolerance_)))
    return {};
  const Point meeting = p + before / (before - after) * (q - p);
  double x = meeting[0];
  double arc_length = side.arc_length(in_plane(meeting));
  if (arc_length < 0 || arc_length > side.length || x < layer.lower || x > layer.upper) return {};
  const double nearest = std::min({x - layer.lower, layer.upper - x, arc_length, side.length - arc_length});
  if (nearest < margin) {
    if (nearest == x - layer.lower)
      x = layer.lower;
    else if (nearest == layer.upper - x)
      x = layer.upper;
    else
      arc_length = nearest == arc_length ? 0 : side.length;
  }
  const plane::Point place = place_on(side, arc_length);
  return Point{x, place[0], place[1]};
}

std::optional<Point> CompositeBody::passage_of_cap(const Cap& cap, const Point& p, const Point& q,
                                                   double margin) const {
  const double before = p[0] - cap.x;
  const double after = q[0] - cap.x;
  if (!((before < 0 && after > 0) || (before > 0 && after < 0))) return {};
  const Point meeting = p + before / (before - after) * (q - p);
  plane::Point place = in_plane(meeting);
  if (!cap.rim.contains(place)) return {};
  const auto distance = [&](const plane::Side& side) { return plane::distance(place, side.from, side.to); };
  const plane::Side& border = *std::ranges::min_element(cap.borders.sides(), {}, distance);
  if (distance(border) < margin) place = place_on(border, border.arc_length(place));
  return Point{cap.x, place[0], place[1]};
}

Point CompositeBody::snapped(const Point& p, double tolerance) const {
  Point result = plain_->snapped(p, tolerance);
  const plane::Point place = in_plane(result);
  for (const Cap& cap : caps_)
    if (std::abs(result[0] - cap.x) <= tolerance &&
        (cap.rim.contains(place) || cap.rim.distance(place) <= tolerance))
      result[0] = cap.x;
  std::vector<const plane::Side*> near;
  const auto collect = [&](const std::vector<plane::Side>& sides) {
    for (const plane::Side& side : sides)
      if (plane::distance(place, side.from, side.to) <= tolerance) near.push_back(&side);
  };
  for (const Layer& layer : layers_)
    if (result[0] >= layer.lower - tolerance && result[0] <= layer.upper + tolerance)
      collect(layer.walls.sides());
  if (near.empty()) return result;
  const std::size_t n_walls = near.size();
  collect(plate_sides_);
  plane::Point moved = place_on(*near.front(), near.front()->arc_length(place));
  const bool is_at_edge = near.size() > n_walls || std::ranges::any_of(near, [&](const plane::Side* side) {
                            return !continues(*side, *near.front());
                          });
  if (is_at_edge) {
    const auto gap = [&](const plane::Point& end) {
      return plane::norm({end[0] - place[0], end[1] - place[1]});
    };
    moved = near.front()->from;
    for (std::size_t i = 0; i < n_walls; ++i)
      for (const plane::Point& end : {near[i]->from, near[i]->to})
        if (gap(end) < gap(moved)) moved = end;
  }
  return {result[0], moved[0], moved[1]};
}

bool CompositeBody::crosses(const Layer& layer, const std::array<Point, 4>& corners) const {
  if (std::ranges::all_of(corners,
                          [&](const Point& p) { return p[0] >= layer.lower && p[0] <= layer.upper; }))
    return layer.walls.cover(std::array{in_plane(corners[0]), in_plane(corners[1]), in_plane(corners[2]),
                                        in_plane(corners[3])}) == plane::Cover::crossing;
  Span span;
  for (const Point& p : corners)
    if (p[0] >= layer.lower && p[0] <= layer.upper) span.add(in_plane(p));
  for (const double x : {layer.lower, layer.upper}) add_section(corners, x, span);
  return layer.walls.cover(span.points()) == plane::Cover::crossing;
}

/// @pre the corners are on both sides of the cap's x
bool CompositeBody::crosses(const Cap& cap, const std::array<Point, 4>& corners) const {
  Span section;
  for (const Point& p : corners)
    if (p[0] == cap.x) section.add(in_plane(p));
  add_section(corners, cap.x, section);
  return cap.rim.cover(section.points()) != plane::Cover::outside;
}

Containment CompositeBody::classify(const std::array<Point, 4>& corners) const {
  const Containment plain = plain_->classify(corners);
  if (plain != Containment::inside) return plain;
  Box around = nowhere;
  for (const Point& p : corners) around.include(p);
  for (const Layer& layer : layers_)
    if (interiors_meet(around, layer.around) && crosses(layer, corners)) return Containment::straddling;
  for (const Cap& cap : caps_)
    if (around.lower[0] < cap.x && around.upper[0] > cap.x && crosses(cap, corners))
      return Containment::straddling;
  return Containment::inside;
}

}  // namespace crackle::geometry
