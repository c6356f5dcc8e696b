// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/outline.h"

#include "common/index.h"
#include "geometry/pre_crack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace crackle::geometry {

namespace {

/// Edges at which faces meet at less than this angle are not drawn, if others are [rad].
constexpr double smooth_angle = 0.35;

/// The edges that people see; all of a body that is smooth everywhere.
void add_edges(const Body& body, Outline& outline) {
  const auto is_seen = [&](const Edge& edge) {
    const auto faces = body.faces_at(body.place_of(edge.at(edge.length() / 2)));
    return faces.size() == 2 && dot(body.faces()[index(faces[0])].outward,
                                    body.faces()[index(faces[1])].outward) < std::cos(smooth_angle);
  };
  const bool is_smooth = std::ranges::none_of(body.edges(), is_seen);
  for (const Edge& edge : body.edges())
    if (is_smooth || is_seen(edge))
      for (const Point& end : {edge.from(), edge.to()})
        outline.edges.insert(outline.edges.end(), end.begin(), end.end());
}

}  // namespace

Outline outline_of(const Body& body, std::span<const plane::PreCrack> flaws) {
  Outline outline;
  const Point size = body.size();
  outline.size.assign(size.begin(), size.end());
  outline.first = {0};
  for (const Polygon& polygon : body.outline()) {
    for (const auto& [y, z] : polygon) outline.points.insert(outline.points.end(), {y, z});
    outline.first.push_back(static_cast<std::int32_t>(outline.points.size() / 2));
  }
  const auto add_border = [&](const std::vector<Point>& border) {
    if (outline.first_of_pre_crack.empty()) outline.first_of_pre_crack = {0};
    for (const Point& p : border) outline.pre_cracks.insert(outline.pre_cracks.end(), {p[1], p[2]});
    outline.first_of_pre_crack.push_back(static_cast<std::int32_t>(outline.pre_cracks.size() / 2));
  };
  for (const CrackStart& start : body.crack_starts()) {
    outline.names.push_back(start.is_straight ? fmt::format("notch-{}", outline.names.size()) : start.name);
    outline.tips.insert(outline.tips.end(), {start.tip[1], start.tip[2]});
    const int axis = std::abs(start.along[1]) > std::abs(start.along[2]) ? 1 : 2;
    outline.axis.push_back(start.is_straight ? axis : 0);
    const int direction = start.direction * start.along[index(axis)] > 0 ? 1 : -1;
    outline.direction.push_back(start.is_straight ? direction : 0);
    Box slot{start.tip, start.tip};
    for (const FaceId face : start.faces) {
      const Box bounds = body.faces()[index(face)].patch.bounds();
      slot.include(bounds.lower);
      slot.include(bounds.upper);
    }
    if (start.plane) {
      const Box bounds = start.plane->bounds();
      slot.include(bounds.lower);
      slot.include(bounds.upper);
      add_border(start.border);
    }
    outline.slots.insert(outline.slots.end(), {slot.lower[1], slot.upper[1], slot.lower[2], slot.upper[2]});
  }
  for (const plane::PreCrack& flaw : flaws) add_border(PreCrackFigure(flaw, body.bounds()).border());
  if (body.outline().empty()) add_edges(body, outline);
  return outline;
}

}  // namespace crackle::geometry
