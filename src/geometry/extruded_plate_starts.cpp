// SPDX-License-Identifier: GPL-3.0-or-later
// Where cracks start in an extruded plate.
#include "extruded_plate.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>

namespace crackle::geometry {

void ExtrudedPlate::add_ligaments() {
  for (std::size_t i = 0; i < notches_.size(); ++i) {
    const input::Notch& notch = notches_[i];
    const auto depth_axis = index(axis_of(notch.face)), at_axis = index(position_axis(notch.face));
    const auto [low, high] = input::slot_of(notch, size())[depth_axis];
    CrackStart start{};
    start.name = fmt::format("notch {}", i + 1);
    start.tip[0] = thickness() / 2;
    start.tip[at_axis] = notch.at;
    start.tip[depth_axis] = is_upper(notch.face) ? low : high;
    start.end = start.tip;
    start.end[depth_axis] = input::ligament_end(notches_, i, size());
    start.along[depth_axis] = 1;
    start.across[at_axis] = 1;
    start.direction = is_upper(notch.face) ? -1 : 1;
    start.ligament = std::abs(start.end[depth_axis] - start.tip[depth_axis]);
    start.faces = faces_named(fmt::format("notch-{}", i));
    start.reach = notch.height;
    shape_.crack_starts.push_back(std::move(start));
  }
}

void ExtrudedPlate::add_round_starts(const std::vector<input::Hole>& holes) {
  const auto add = [&](const std::string& part, const plane::Point& middle) {
    CrackStart start{};
    start.name = part;
    start.tip = {thickness() / 2, middle[0], middle[1]};
    start.is_straight = false;
    start.faces = faces_named(part);
    shape_.crack_starts.push_back(std::move(start));
  };
  for (std::size_t i = 0; i < notches_.size(); ++i) {
    const std::string part = fmt::format("notch-{}", i);
    // The mean position of its walls, away from the mouth.
    plane::Point middle{};
    double length = 0;
    for (const FaceId face : faces_named(part)) {
      const plane::Side& side = side_of(face);
      for (std::size_t k = 0; k < 2; ++k) middle[k] += side.length * (side.from[k] + side.to[k]) / 2;
      length += side.length;
    }
    for (double& coordinate : middle) coordinate /= length;
    add(part, middle);
  }
  for (std::size_t i = 0; i < holes.size(); ++i) {
    plane::Point middle = holes[i].center;
    if (!holes[i].polygon.empty()) {
      const plane::Bounds around = plane::bounds_of(holes[i].polygon);
      for (std::size_t k = 0; k < 2; ++k) middle[k] = (around.lower[k] + around.upper[k]) / 2;
    }
    add(fmt::format("hole-{}", i), middle);
    shape_.crack_starts.back().is_hole = true;
  }
  const Point centre = bounds().lower + size() / 2;
  add("free surface", {centre[1], centre[2]});
  shape_.crack_starts.back().is_free_surface = true;
}

std::size_t n_crack_starts(const input::Specimen& specimen) {
  if (input::is_box(specimen)) return specimen.notches.size();
  return specimen.notches.size() + specimen.holes.size() + 1;
}

}  // namespace crackle::geometry
