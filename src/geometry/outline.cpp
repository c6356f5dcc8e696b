// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/outline.h"

#include <algorithm>
#include <utility>

namespace crackle::geometry {

namespace {

using input::Face;

/// The way along a face of the box, into its slots and out, as pairs of the coordinates along and across the
/// face; from the end at 0 to the other one.
std::vector<std::pair<double, double>> way_along(const Body& body, Face face) {
  std::vector<SlotSection> slots;
  for (int i = 0; i < body.n_notches(); ++i)
    if (body.notch(i).face == face) slots.push_back(body.sections()[static_cast<std::size_t>(i)]);
  std::ranges::sort(slots, {}, &SlotSection::lower);
  const auto length = [&](int axis) { return body.size()[static_cast<std::size_t>(axis)]; };
  const double at_face = input::is_upper(face) ? length(input::axis_of(face)) : 0.0;
  std::vector<std::pair<double, double>> way{{0, at_face}};
  for (const SlotSection& slot : slots) {
    way.insert(
        way.end(),
        {{slot.lower, slot.mouth}, {slot.lower, slot.tip}, {slot.upper, slot.tip}, {slot.upper, slot.mouth}});
  }
  way.emplace_back(length(input::position_axis(face)), at_face);
  return way;
}

}  // namespace

Outline outline_of(const Body& body) {
  Outline outline;
  outline.size.assign(body.size().begin(), body.size().end());
  for (const auto& [face, is_backwards] :
       {std::pair{Face::z_min, false}, {Face::y_max, false}, {Face::z_max, true}, {Face::y_min, true}}) {
    auto way = way_along(body, face);
    if (is_backwards) std::ranges::reverse(way);
    way.pop_back();  // the next face begins there
    for (auto [along, across] : way) {
      if (input::axis_of(face) == 1) std::swap(along, across);
      outline.points.insert(outline.points.end(), {along, across});
    }
  }
  outline.first = {0, static_cast<std::int32_t>(outline.points.size() / 2)};
  for (const SlotSection& slot : body.sections()) {
    std::array<double, 3> tip{};
    tip[static_cast<std::size_t>(slot.at_axis)] = (slot.lower + slot.upper) / 2;
    tip[static_cast<std::size_t>(slot.depth_axis)] = slot.tip;
    outline.tips.insert(outline.tips.end(), {tip[1], tip[2]});
    outline.axis.push_back(slot.depth_axis);
    outline.direction.push_back(slot.mouth < slot.tip ? 1 : -1);
  }
  for (int i = 0; i < body.n_notches(); ++i) {
    const Box& slot = body.slot(i);
    outline.slots.insert(outline.slots.end(), {slot.lower[1], slot.upper[1], slot.lower[2], slot.upper[2]});
  }
  return outline;
}

}  // namespace crackle::geometry
