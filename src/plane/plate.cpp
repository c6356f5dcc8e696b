// SPDX-License-Identifier: GPL-3.0-or-later
#include "plane/plate.h"

#include "common/failure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace crackle::plane {

namespace {

/// @throws std::runtime_error unless the notch is a slot inside its face, apart from those before it
void check_notch(const Specimen& specimen, std::size_t i) {
  const Vector& size = specimen.size;
  const auto name_of_notch = [&](std::size_t number) {
    return fmt::format("notch {} ({})", number + 1, name_of(specimen.notches[number].face));
  };
  const Notch& notch = specimen.notches[i];
  const std::string name = name_of_notch(i);
  if (axis_of(notch.face) == 0) fail("{}: a notch is cut into y-min, y-max, z-min or z-max", name);
  if (!(notch.depth > 0) || !(notch.height > 0)) fail("{}: depth and height must be positive", name);
  const Region bounds = bounds_of(specimen), slot = slot_of(notch, bounds);
  const auto along = index(position_axis(notch.face)), across = index(axis_of(notch.face));
  if (!(slot[along].first > 0) || !(slot[along].second < size[along]))
    fail("{}: the slot from {} m to {} m does not lie inside the face, which ends at 0 and {} m", name,
         slot[along].first, slot[along].second, size[along]);
  if (!(notch.depth < size[across]))
    fail("{}: depth {} m cuts the body in two; it must be below {} m", name, notch.depth, size[across]);
  for (std::size_t j = 0; j < i; ++j)
    if (meet(slot, slot_of(specimen.notches[j], bounds), {}))
      fail("{} and {} overlap or touch; they would cut the body in two or leave no material between them",
           name_of_notch(j), name);
}

/// @throws std::runtime_error for a body that does not exist
void check_box(const Specimen& specimen) {
  for (const double length : specimen.size)
    if (!(length > 0) || !std::isfinite(length))
      fail("specimen: size must be three positive lengths, not {} m", length);
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) check_notch(specimen, i);
}

/// The notches in a face, in order along the face's edge of the outline.
std::vector<std::size_t> notches_along(const Specimen& specimen, Face face, bool is_backwards) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < specimen.notches.size(); ++i)
    if (specimen.notches[i].face == face) numbers.push_back(i);
  std::ranges::sort(numbers, {}, [&](std::size_t i) { return specimen.notches[i].at; });
  if (is_backwards) std::ranges::reverse(numbers);
  return numbers;
}

Shape shape_of_box(const Specimen& specimen) {
  check_box(specimen);
  Shape shape{{{}}, {}};
  for (std::size_t edge = 0; edge < box_edges.size(); ++edge)
    shape.parts.push_back({fmt::format("edge-{}", edge)});
  for (std::size_t i = 0; i < specimen.notches.size(); ++i)
    shape.parts.push_back({fmt::format("notch-{}", i)});
  Loop& loop = shape.loops.front();
  for (std::size_t edge = 0; edge < box_edges.size(); ++edge) {
    const Face face = box_edges[edge];
    const bool is_backwards = edge >= 2;
    const auto across = index(axis_of(face)), along = index(position_axis(face));
    const double mouth = is_upper(face) ? specimen.size[across] : 0;
    const auto add = [&](double way, double depth, std::size_t part) {
      Point p{};
      p[along - 1] = way;
      p[across - 1] = depth;
      loop.corners.push_back(p);
      loop.part.push_back(static_cast<int>(part));
    };
    add(is_backwards ? specimen.size[along] : 0, mouth, edge);
    for (const std::size_t i : notches_along(specimen, face, is_backwards)) {
      const Region slot = slot_of(specimen.notches[i], bounds_of(specimen));
      auto [first, last] = slot[along];
      if (is_backwards) std::swap(first, last);
      const double tip = is_upper(face) ? slot[across].first : slot[across].second;
      const std::size_t part = box_edges.size() + i;
      add(first, mouth, part);
      add(first, tip, part);
      add(last, tip, part);
      add(last, mouth, edge);
    }
  }
  return shape;
}

}  // namespace

bool is_box(const Specimen& specimen) {
  return !specimen.outline && !specimen.shape && !specimen.solid && specimen.holes.empty() &&
         std::ranges::none_of(specimen.notches, [](const Notch& notch) { return notch.slot.has_value(); });
}

Region slot_of(const Notch& notch, const Region& bounds) {
  Region slot = bounds;
  auto& [lower, upper] = slot[index(axis_of(notch.face))];
  if (is_upper(notch.face))
    lower = upper - notch.depth;
  else
    upper = lower + notch.depth;
  slot[index(position_axis(notch.face))] = {notch.at - notch.height / 2, notch.at + notch.height / 2};
  return slot;
}

bool meet(const Region& slot, const Region& other, const Vector& near) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (slot[axis].first - other[axis].second > near[axis] ||
        other[axis].first - slot[axis].second > near[axis])
      return false;
  return true;
}

double ligament_end(const Specimen& specimen, std::size_t i) {
  const Notch& notch = specimen.notches[i];
  const Region bounds = bounds_of(specimen);
  const auto depth_axis = index(axis_of(notch.face)), at_axis = index(position_axis(notch.face));
  const bool ascends = !is_upper(notch.face);
  const auto [own_low, own_high] = slot_of(notch, bounds)[depth_axis];
  const double tip = ascends ? own_high : own_low;
  double end = ascends ? bounds[depth_axis].second : bounds[depth_axis].first;
  for (const Notch& other : specimen.notches) {
    const Region slot = slot_of(other, bounds);
    if (!(notch.at > slot[at_axis].first && notch.at < slot[at_axis].second)) continue;
    const auto [low, high] = slot[depth_axis];
    if (ascends && low > tip) end = std::min(end, low);
    if (!ascends && high < tip) end = std::max(end, high);
  }
  return end;
}

Region bounds_of(const Specimen& specimen) {
  if (specimen.solid) return specimen.solid->bounds;
  Region bounds;
  for (std::size_t i = 0; i < 3; ++i) bounds[i] = {0, specimen.size[i]};
  if (specimen.outline && !specimen.outline->polygon.empty()) {
    const Bounds around = bounds_of(specimen.outline->polygon);
    for (std::size_t i = 0; i < 2; ++i) bounds[i + 1] = {around.lower[i], around.upper[i]};
  }
  return bounds;
}

Shape shape_of(const Specimen& specimen) {
  if (specimen.shape) return *specimen.shape;
  if (!is_box(specimen)) throw std::invalid_argument("specimen: the shape of the plate is not known");
  return shape_of_box(specimen);
}

}  // namespace crackle::plane
