// SPDX-License-Identifier: GPL-3.0-or-later
#include "notched_box.h"

#include "crackle/common/failure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace crackle::geometry {

namespace {

SlotSection section_of(const input::Notch& notch, const Point& size) {
  SlotSection section{};
  section.depth_axis = axis_of(notch.face);
  section.at_axis = position_axis(notch.face);
  section.lower = notch.at - notch.height / 2;
  section.upper = notch.at + notch.height / 2;
  section.mouth = is_upper(notch.face) ? size[index(section.depth_axis)] : 0.0;
  section.tip = is_upper(notch.face) ? size[index(section.depth_axis)] - notch.depth : notch.depth;
  return section;
}

Box slot_of(const SlotSection& section, const Point& size) {
  Box slot{{0, 0, 0}, size};
  slot.lower[index(section.at_axis)] = section.lower;
  slot.upper[index(section.at_axis)] = section.upper;
  slot.lower[index(section.depth_axis)] = std::min(section.mouth, section.tip);
  slot.upper[index(section.depth_axis)] = std::max(section.mouth, section.tip);
  return slot;
}

/// @throws std::runtime_error when the notch is not a slot inside its face
void check_notch(const input::Notch& notch, const Point& size, std::size_t number) {
  const std::string name = fmt::format("notch {} ({})", number + 1, name_of(notch.face));
  if (axis_of(notch.face) == 0)
    throw std::runtime_error(name + ": a notch is cut into y-min, y-max, z-min or z-max");
  const SlotSection section = section_of(notch, size);
  const double depth_limit = size[index(section.depth_axis)];
  const double at_limit = size[index(section.at_axis)];
  if (!(notch.height > 0) || !(notch.depth > 0))
    throw std::runtime_error(name + ": depth and height must be positive");
  if (!(section.lower > 0) || !(section.upper < at_limit))
    fail("{}: the slot from {} m to {} m does not lie inside the face, which ends at 0 and {} m", name,
         section.lower, section.upper, at_limit);
  if (!(section.tip > 0) || !(section.tip < depth_limit))
    fail("{}: depth {} m cuts the body in two; it must be below {} m", name, notch.depth, depth_limit);
}

/// Overlap area of a slot's opening or cross-section with the face of the box at axis = position.
double opening(const Box& slot, int axis, double position) {
  if (slot.lower[index(axis)] > position || slot.upper[index(axis)] < position) return 0;
  const std::size_t i = index((axis + 1) % 3);
  const std::size_t j = index((axis + 2) % 3);
  return (slot.upper[i] - slot.lower[i]) * (slot.upper[j] - slot.lower[j]);
}

Vector unit(int axis, double length = 1) {
  Vector vector{};
  vector[index(axis)] = length;
  return vector;
}

}  // namespace

NotchedBox::NotchedBox(const input::Specimen& specimen) : notches_(specimen.notches) {
  for (const double length : specimen.size)
    if (!(length > 0) || !std::isfinite(length))
      fail("specimen: size must be three positive lengths, not {} m", length);
  shape_.bounds = {{0, 0, 0}, specimen.size};
  cut_slots();
  add_faces();
  add_edges();
  add_corners();
  add_crack_starts();
  add_outline();
}

void NotchedBox::cut_slots() {
  const Point& size = shape_.bounds.upper;
  shape_.volume = size[0] * size[1] * size[2];
  for (std::size_t i = 0; i < notches_.size(); ++i) {
    check_notch(notches_[i], size, i);
    const SlotSection section = section_of(notches_[i], size);
    sections_.push_back(section);
    slots_.push_back(slot_of(section, size));
    for (std::size_t j = 0; j < i; ++j)
      if (distance(slots_[i], slots_[j]) <= 0)
        fail(
            "notch {} ({}) and notch {} ({}) overlap or touch; they would cut the body in two or "
            "leave no material between them",
            j + 1, name_of(notches_[j].face), i + 1, name_of(notches_[i].face));
    shape_.volume -= size[0] * (section.upper - section.lower) * std::abs(section.tip - section.mouth);
  }
}

void NotchedBox::add_face(std::string name, const Box& box, int axis, double position, double outward) {
  Patch patch{box};
  patch.domain.lower[index(axis)] = position;
  patch.domain.upper[index(axis)] = position;
  const double area = opening(box, axis, position);
  axis_.push_back(axis);
  shape_.faces.push_back({{std::move(name)}, area, unit(axis, outward), patch});
}

void NotchedBox::add_faces() {
  for (const char* const name : input::face_names) {
    const auto face = static_cast<input::Face>(shape_.faces.size());
    const int axis = axis_of(face);
    const double position = is_upper(face) ? shape_.bounds.upper[index(axis)] : 0.0;
    add_face(name, shape_.bounds, axis, position, is_upper(face) ? 1.0 : -1.0);
    if (const auto edge = std::ranges::find(input::box_edges, face); edge != input::box_edges.end())
      shape_.faces.back().names.push_back(fmt::format("edge-{}", edge - input::box_edges.begin()));
    for (const Box& slot : slots_) shape_.faces.back().area -= opening(slot, axis, position);
  }
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const SlotSection& section = sections_[i];
    const auto add = [&](const char* part, int axis, double position, double outward) {
      add_face(fmt::format("notch[{}] {}", i, part), slots_[i], axis, position, outward);
      shape_.faces.back().names.push_back(fmt::format("notch-{}", i));
    };
    add("lower wall", section.at_axis, section.lower, 1.0);
    add("upper wall", section.at_axis, section.upper, -1.0);
    add("tip", section.depth_axis, section.tip, section.tip > section.mouth ? -1.0 : 1.0);
  }
}

void NotchedBox::add_edges() {
  const Point& length = shape_.bounds.upper;
  const auto add = [&](int axis, const Point& from, double end) {
    Point to = from;
    to[index(axis)] = end;
    shape_.edges.emplace_back(from, to);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const std::size_t i = index((axis + 1) % 3);
    const std::size_t j = index((axis + 2) % 3);
    for (const double position_i : {0.0, length[i]}) {
      for (const double position_j : {0.0, length[j]}) {
        Point from{};
        from[i] = position_i;
        from[j] = position_j;
        // The openings that interrupt this edge of the box, in order.
        std::vector<std::pair<double, double>> openings;
        for (const Box& slot : slots_)
          if (slot.lower[i] <= position_i && position_i <= slot.upper[i] && slot.lower[j] <= position_j &&
              position_j <= slot.upper[j])
            openings.emplace_back(slot.lower[index(axis)], slot.upper[index(axis)]);
        std::sort(openings.begin(), openings.end());
        openings.emplace_back(length[index(axis)], length[index(axis)]);
        for (const auto& [begin, end] : openings) {
          add(axis, from, begin);
          from[index(axis)] = end;
        }
      }
    }
  }
  for (const SlotSection& section : sections_) {
    for (const double wall : {section.lower, section.upper}) {
      for (const double depth : {section.mouth, section.tip}) {
        Point from{};
        from[index(section.at_axis)] = wall;
        from[index(section.depth_axis)] = depth;
        add(0, from, length[0]);
      }
      for (const double x : {0.0, length[0]}) {
        Point from{x, 0, 0};
        from[index(section.at_axis)] = wall;
        from[index(section.depth_axis)] = std::min(section.mouth, section.tip);
        add(section.depth_axis, from, std::max(section.mouth, section.tip));
      }
    }
    for (const double x : {0.0, length[0]}) {
      Point from{x, 0, 0};
      from[index(section.at_axis)] = section.lower;
      from[index(section.depth_axis)] = section.tip;
      add(section.at_axis, from, section.upper);
    }
  }
}

void NotchedBox::add_corners() {
  const auto add = [&](const Box& box) {
    for (const Point& corner : corners_of(box)) shape_.corners.push_back(corner);
  };
  add(shape_.bounds);
  for (const Box& slot : slots_) add(slot);
}

void NotchedBox::add_crack_starts() {
  const Point& size = shape_.bounds.upper;
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const SlotSection& section = sections_[i];
    const std::size_t depth_axis = index(section.depth_axis);
    const bool ascends = section.mouth < section.tip;
    CrackStart start{};
    start.name = fmt::format("notch {}", i + 1);
    start.tip[0] = size[0] / 2;
    start.tip[index(section.at_axis)] = notches_[i].at;
    start.tip[depth_axis] = section.tip;
    start.end = start.tip;
    start.end[depth_axis] = input::ligament_end(notches_, i, size);
    start.along = unit(section.depth_axis);
    start.across = unit(section.at_axis);
    start.direction = ascends ? 1 : -1;
    start.ligament = std::abs(start.end[depth_axis] - section.tip);
    for (FaceId part = 0; part < 3; ++part) start.faces.push_back(6 + 3 * static_cast<FaceId>(i) + part);
    start.reach = notches_[i].height;
    shape_.crack_starts.push_back(std::move(start));
  }
}

void NotchedBox::add_outline() {
  Polygon polygon;
  for (const input::Face face : input::box_edges) {
    const bool is_backwards = face == input::Face::z_max || face == input::Face::y_min;
    const double at_face = is_upper(face) ? shape_.bounds.upper[index(axis_of(face))] : 0.0;
    std::vector<SlotSection> slots;
    for (std::size_t i = 0; i < notches_.size(); ++i)
      if (notches_[i].face == face) slots.push_back(sections_[i]);
    std::ranges::sort(slots, {}, &SlotSection::lower);
    // Along the face, into its slots and out again, in coordinates along and across it.
    Polygon way{{0, at_face}};
    for (const SlotSection& slot : slots)
      way.insert(way.end(), {{slot.lower, slot.mouth},
                             {slot.lower, slot.tip},
                             {slot.upper, slot.tip},
                             {slot.upper, slot.mouth}});
    way.push_back({shape_.bounds.upper[index(position_axis(face))], at_face});
    if (is_backwards) std::ranges::reverse(way);
    way.pop_back();  // start of the next face
    for (const auto& [along, across] : way)
      polygon.push_back(axis_of(face) == 1 ? std::array{across, along} : std::array{along, across});
  }
  shape_.outline = {std::move(polygon)};
}

}  // namespace crackle::geometry
