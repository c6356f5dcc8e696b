// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/body.h"

#include "crackle/common/index.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace crackle::geometry {

namespace {

constexpr std::size_t at(int axis) {
  return static_cast<std::size_t>(axis);
}

SlotSection section_of(const input::Notch& notch, const Point& size) {
  SlotSection section{};
  section.depth_axis = axis_of(notch.face);
  section.at_axis = position_axis(notch.face);
  section.lower = notch.at - notch.height / 2;
  section.upper = notch.at + notch.height / 2;
  section.mouth = is_upper(notch.face) ? size[at(section.depth_axis)] : 0.0;
  section.tip = is_upper(notch.face) ? size[at(section.depth_axis)] - notch.depth : notch.depth;
  return section;
}

Box slot_of(const SlotSection& section, const Point& size) {
  Box slot{{0, 0, 0}, size};
  slot.lower[at(section.at_axis)] = section.lower;
  slot.upper[at(section.at_axis)] = section.upper;
  slot.lower[at(section.depth_axis)] = std::min(section.mouth, section.tip);
  slot.upper[at(section.depth_axis)] = std::max(section.mouth, section.tip);
  return slot;
}

/// @throws std::runtime_error unless the notch is a slot inside its face
void check_notch(const input::Notch& notch, const Point& size, int number) {
  const std::string name = fmt::format("notch {} ({})", number + 1, name_of(notch.face));
  if (axis_of(notch.face) == 0)
    throw std::runtime_error(name + ": a notch is cut into y-min, y-max, z-min or z-max");
  const SlotSection section = section_of(notch, size);
  const double depth_limit = size[at(section.depth_axis)];
  const double at_limit = size[at(section.at_axis)];
  if (!(notch.height > 0) || !(notch.depth > 0))
    throw std::runtime_error(name + ": depth and height must be positive");
  if (!(section.lower > 0) || !(section.upper < at_limit))
    throw std::runtime_error(
        fmt::format("{}: the slot from {} m to {} m does not lie inside the face, which ends at 0 and {} m",
                    name, section.lower, section.upper, at_limit));
  if (!(section.tip > 0) || !(section.tip < depth_limit))
    throw std::runtime_error(fmt::format("{}: depth {} m cuts the body in two; it must be below {} m", name,
                                         notch.depth, depth_limit));
}

/// Area of the overlap of a slot's opening or cross-section with the face of the box at axis = position.
double opening(const Box& slot, int axis, double position) {
  if (slot.lower[at(axis)] > position || slot.upper[at(axis)] < position) return 0;
  const int i = (axis + 1) % 3;
  const int j = (axis + 2) % 3;
  return (slot.upper[at(i)] - slot.lower[at(i)]) * (slot.upper[at(j)] - slot.lower[at(j)]);
}

Surface plane_piece(Box extent, int axis, double position, double outward) {
  extent.lower[at(axis)] = position;
  extent.upper[at(axis)] = position;
  const int i = (axis + 1) % 3;
  const int j = (axis + 2) % 3;
  const double area =
      (extent.upper[at(i)] - extent.lower[at(i)]) * (extent.upper[at(j)] - extent.lower[at(j)]);
  return {axis, position, area, outward, extent};
}

}  // namespace

double distance(const Point& p, const Box& box) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double gap = std::max({box.lower[i] - p[i], p[i] - box.upper[i], 0.0});
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

double distance(const Box& a, const Box& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double gap = std::max({a.lower[i] - b.upper[i], b.lower[i] - a.upper[i], 0.0});
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

Body::Body(input::Specimen specimen) : specimen_(std::move(specimen)) {
  const Point& size = specimen_.size;
  for (const double length : size)
    if (!(length > 0) || !std::isfinite(length))
      throw std::runtime_error(
          fmt::format("specimen: size must be three positive lengths, not {} m", length));

  for (int i = 0; i < n_notches(); ++i) {
    check_notch(notch(i), size, i);
    sections_.push_back(section_of(notch(i), size));
    slots_.push_back(slot_of(sections_.back(), size));
    for (int j = 0; j < i; ++j)
      if (distance(slot(i), slot(j)) <= 0)
        throw std::runtime_error(
            fmt::format("notch {} ({}) and notch {} ({}) overlap or touch; they would cut the body in two or "
                        "leave no material between them",
                        j + 1, name_of(notch(j).face), i + 1, name_of(notch(i).face)));
  }

  const Box box{{0, 0, 0}, size};
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      Surface face = plane_piece(box, axis, upper ? size[at(axis)] : 0.0, upper ? 1.0 : -1.0);
      for (const Box& slot : slots_) face.area -= opening(slot, axis, face.position);
      surfaces_.push_back(face);
    }
  }
  volume_ = size[0] * size[1] * size[2];
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const SlotSection& section = sections_[i];
    surfaces_.push_back(plane_piece(slots_[i], section.at_axis, section.lower, 1.0));
    surfaces_.push_back(plane_piece(slots_[i], section.at_axis, section.upper, -1.0));
    surfaces_.push_back(
        plane_piece(slots_[i], section.depth_axis, section.tip, section.tip > section.mouth ? -1.0 : 1.0));
    volume_ -= size[0] * (section.upper - section.lower) * std::abs(section.tip - section.mouth);
  }
}

std::vector<Edge> Body::edges() const {
  std::vector<Edge> edges;
  const Point& length = size();
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t i = at((axis + 1) % 3);
    const std::size_t j = at((axis + 2) % 3);
    for (const double position_i : {0.0, length[i]}) {
      for (const double position_j : {0.0, length[j]}) {
        Point from{};
        from[i] = position_i;
        from[j] = position_j;
        // The openings that interrupt this edge of the box, one after the other.
        std::vector<std::pair<double, double>> openings;
        for (const Box& slot : slots_)
          if (slot.lower[i] <= position_i && position_i <= slot.upper[i] && slot.lower[j] <= position_j &&
              position_j <= slot.upper[j])
            openings.emplace_back(slot.lower[at(axis)], slot.upper[at(axis)]);
        std::sort(openings.begin(), openings.end());
        openings.emplace_back(length[at(axis)], length[at(axis)]);
        for (const auto& [begin, end] : openings) {
          Point to = from;
          to[at(axis)] = begin;
          edges.push_back({axis, from, to});
          from[at(axis)] = end;
        }
      }
    }
  }
  for (const SlotSection& section : sections_) {
    const auto edge = [&](int axis, Point from, double end) {
      Point to = from;
      to[at(axis)] = end;
      edges.push_back({axis, from, to});
    };
    for (const double wall : {section.lower, section.upper}) {
      for (const double depth : {section.mouth, section.tip}) {
        Point from{};
        from[at(section.at_axis)] = wall;
        from[at(section.depth_axis)] = depth;
        edge(0, from, length[0]);
      }
      for (const double x : {0.0, length[0]}) {
        Point from{x, 0, 0};
        from[at(section.at_axis)] = wall;
        from[at(section.depth_axis)] = std::min(section.mouth, section.tip);
        edge(section.depth_axis, from, std::max(section.mouth, section.tip));
      }
    }
    for (const double x : {0.0, length[0]}) {
      Point from{x, 0, 0};
      from[at(section.at_axis)] = section.lower;
      from[at(section.depth_axis)] = section.tip;
      edge(section.at_axis, from, section.upper);
    }
  }
  return edges;
}

std::vector<Point> Body::corners() const {
  std::vector<Point> corners;
  const auto add = [&](const Box& box) {
    for (int corner = 0; corner < 8; ++corner) {
      Point p{};
      for (std::size_t i = 0; i < 3; ++i) p[i] = (corner >> i) & 1 ? box.upper[i] : box.lower[i];
      corners.push_back(p);
    }
  };
  add({{0, 0, 0}, size()});
  for (const Box& slot : slots_) add(slot);
  return corners;
}

double Body::distance_to_notch_tip(const Point& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < n_notches(); ++i)
    nearest = std::min(nearest, distance(p, surfaces_[index(8 + 3 * i)].extent));
  return nearest;
}

bool Body::contains(const Point& p) const {
  if (!Box{{0, 0, 0}, size()}.contains(p)) return false;
  return std::none_of(sections_.begin(), sections_.end(), [&](const SlotSection& section) {
    const double a = p[at(section.at_axis)];
    const double d = p[at(section.depth_axis)];
    const bool before_tip = section.tip > section.mouth ? d < section.tip : d > section.tip;
    return section.lower < a && a < section.upper && before_tip;
  });
}

std::uint8_t Body::movable_axes(const Point& p) const {
  unsigned fixed = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (p[i] == 0 || p[i] == size()[i]) fixed |= 1u << i;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (!slots_[i].contains(p)) continue;
    const SlotSection& section = sections_[i];
    const double a = p[at(section.at_axis)];
    if (a == section.lower || a == section.upper) fixed |= 1u << section.at_axis;
    if (p[at(section.depth_axis)] == section.tip) fixed |= 1u << section.depth_axis;
  }
  return static_cast<std::uint8_t>(7u & ~fixed);
}

double Body::distance_to_surface(const Point& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) nearest = std::min({nearest, p[i], size()[i] - p[i]});
  for (const Box& slot : slots_) nearest = std::min(nearest, distance(p, slot));
  return nearest;
}

}  // namespace crackle::geometry
