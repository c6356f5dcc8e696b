// SPDX-License-Identifier: GPL-3.0-or-later
// Spacing sources and symmetries of an extruded plate.
#include "crackle/geometry/mother_points.h"
#include "extruded_plate.h"
#include "reflection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace crackle::geometry {

namespace {

/// Both ends of a free slot, or the tip of a notch in a face.
std::vector<plane::Point> notch_ends(const input::Notch& notch, const Box& bounds) {
  if (notch.slot) return {notch.slot->from, notch.slot->to};
  const std::size_t depth_axis = index(axis_of(notch.face));
  plane::Point tip{};
  tip[depth_axis - 1] =
      is_upper(notch.face) ? bounds.upper[depth_axis] - notch.depth : bounds.lower[depth_axis] + notch.depth;
  tip[index(position_axis(notch.face)) - 1] = notch.at;
  return {tip};
}

}  // namespace

SpacingSource ExtrudedPlate::wall_source(const plane::Point& from, const plane::Point& to, double spacing,
                                         double growth, std::string reason) const {
  const Box box{{0, std::min(from[0], to[0]), std::min(from[1], to[1])},
                {thickness(), std::max(from[0], to[0]), std::max(from[1], to[1])}};
  SpacingSource source{box, spacing, growth, std::move(reason)};
  if (from[0] != to[0] && from[1] != to[1]) source.wall = {from, to};
  return source;
}

/// The walls at the tips of slots: those of a half circle or a rectangle at the end.
std::vector<SpacingSource> ExtrudedPlate::tip_sources(const input::Mesh& mesh) const {
  std::vector<SpacingSource> sources;
  for (std::size_t i = 0; i < notches_.size(); ++i) {
    const input::Notch& notch = notches_[i];
    const std::vector<plane::Point> ends = notch_ends(notch, bounds());
    // The corners of a square end are half a height away, those of a round one at most 1 / sqrt(2) heights.
    const bool is_round = notch.slot && notch.slot->end == input::SlotEnd::round;
    const double reach = (is_round ? 0.7072 : 0.5001) * notch.height;
    for (const FaceId face : faces_named(fmt::format("notch-{}", i))) {
      const plane::Side& side = side_of(face);
      if (std::ranges::any_of(ends, [&](const plane::Point& end) {
            return plane::norm({side.from[0] - end[0], side.from[1] - end[1]}) <= reach &&
                   plane::norm({side.to[0] - end[0], side.to[1] - end[1]}) <= reach;
          }))
        sources.push_back(wall_source(side.from, side.to, mesh.notch_spacing, mesh.growth,
                                      fmt::format("notch_spacing at notch {}", i + 1)));
    }
  }
  return sources;
}

std::string ExtrudedPlate::name_in_messages(std::size_t side) const {
  const std::string& name = faces()[first_wall + side].names.front();
  if (name.starts_with("notch-")) return fmt::format("notch {}", std::stoi(name.substr(6)) + 1);
  return std::ranges::find(input::face_names, name) == input::face_names.end() ? name : "the face " + name;
}

std::string ExtrudedPlate::reason_for_length(std::size_t side) const {
  const bool is_whole =
      std::ranges::count(index_.sides(), index_.sides()[side].part, &plane::Side::part) == 1;
  return fmt::format("the length of {}{}", is_whole ? "" : "a side of ", name_in_messages(side));
}

std::string ExtrudedPlate::reason_for_gap(std::size_t side, std::size_t other) const {
  const std::string name = name_in_messages(side);
  const std::string other_name = name_in_messages(other);
  if (name != other_name) return fmt::format("the distance between {} and {}", name, other_name);
  const bool is_slot = name.starts_with("notch") && crack_starts().front().is_straight;
  return fmt::format("the {} of {}", is_slot ? "height" : "shape", name);
}

/// For each side the others whose distance to it counts.
std::vector<std::vector<std::size_t>> ExtrudedPlate::facing_sides() const {
  const auto& sides = index_.sides();
  const auto are_neighbours = [&](std::size_t a, std::size_t b) {
    return sides[a].from == sides[b].to || sides[a].to == sides[b].from;
  };
  std::vector<std::set<int>> mouths(sides.size());  // the slots that open beside each side
  for (std::size_t a = 0; a < sides.size(); ++a)
    for (std::size_t b = 0; b < sides.size(); ++b)
      if (are_neighbours(a, b) && sides[a].part != sides[b].part &&
          plate_.parts[index(sides[b].part)].name.starts_with("notch-"))
        mouths[a].insert(sides[b].part);
  std::vector<std::vector<std::size_t>> facing(sides.size());
  for (std::size_t a = 0; a < sides.size(); ++a)
    for (std::size_t b = 0; b < sides.size(); ++b) {
      const bool same_curve = sides[a].part == sides[b].part && plate_.parts[index(sides[a].part)].is_curve;
      // A wall beside a slot's mouth is close to those across it only through the slot, which does not count.
      const bool across_mouth = std::ranges::any_of(
          mouths[a], [&](int slot) { return sides[b].part == slot || mouths[b].contains(slot); });
      if (a != b && !are_neighbours(a, b) && !same_curve && !across_mouth) facing[a].push_back(b);
    }
  return facing;
}

std::vector<SpacingSource> ExtrudedPlate::spacing_sources(const input::Mesh& mesh) const {
  std::vector<SpacingSource> sources = tip_sources(mesh);
  const double far = mesh.spacing;
  // Walls are compared with these alone: of two close walls both refine the mesh, whichever comes first.
  // Chords are compared with those of their own curve too, as each would be a source otherwise.
  std::vector<SpacingSource> given = region_sources(mesh, bounds());
  given.insert(given.end(), sources.begin(), sources.end());
  bool is_chord = false;
  std::size_t own_curve = 0;  // the first source of a chord's curve
  const auto is_finer = [&](double wanted, const plane::Point& from, const plane::Point& to) {
    const Point middle{thickness() / 2, (from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
    double spacing = far;
    for (const SpacingSource& source : given) spacing = std::min(spacing, source.at(middle));
    for (std::size_t i = own_curve; is_chord && i < sources.size(); ++i)
      spacing = std::min(spacing, sources[i].at(middle));
    return wanted * fine_enough < spacing;
  };
  // The length of a wall, and the distance of others to each piece of it.
  const auto& sides = index_.sides();
  const std::vector<std::vector<std::size_t>> facing = facing_sides();
  for (std::size_t s = 0; s < sides.size(); ++s) {
    const plane::Side& side = sides[s];
    if (s == 0 || side.part != sides[s - 1].part) own_curve = sources.size();
    is_chord = plate_.parts[index(side.part)].is_curve;
    const auto add = [&](const plane::Point& from, const plane::Point& to, double spacing,
                         std::string reason) {
      sources.push_back(wall_source(from, to, spacing, shape_growth(mesh), std::move(reason)));
    };
    if (is_finer(side.length, side.from, side.to)) add(side.from, side.to, side.length, reason_for_length(s));
    const double n_pieces = std::clamp(std::ceil(side.length / far), 1.0, 1000.0);
    const auto place = [&](double piece) {
      const double arc_length = piece / n_pieces * side.length;
      return piece == n_pieces ? side.to
                               : plane::Point{side.from[0] + arc_length * side.along[0],
                                              side.from[1] + arc_length * side.along[1]};
    };
    plane::Point begin = side.from;  // of pieces in a row with one gap, which are one source
    double last_gap = far;
    for (double piece = 0; piece < n_pieces; ++piece) {
      const plane::Point from = place(piece);
      const plane::Point to = place(piece + 1);
      double gap = far;
      std::size_t nearest = s;
      for (const std::size_t other : facing[s]) {
        const double distance = plane::distance(from, to, sides[other].from, sides[other].to);
        if (distance < gap) nearest = other;
        gap = std::min(gap, distance);
      }
      if (!is_finer(gap, from, to)) gap = far;
      if (gap < far && std::abs(gap - last_gap) <= index_.tolerance()) {
        gap = last_gap;
        sources.pop_back();
      } else {
        begin = from;
      }
      if (gap < far) add(begin, to, gap, reason_for_gap(s, nearest));
      last_gap = gap;
    }
  }
  return sources;
}

/// Reflections that map walls onto walls, to the tolerance; always including those along x.
std::vector<Symmetry> ExtrudedPlate::symmetries() const {
  std::array<std::vector<double>, 3> planes;
  planes[0] = {0, thickness()};
  for (const plane::Side& side : index_.sides())
    for (std::size_t i = 0; i < 2; ++i)
      if (side.along[i] == 0) planes[i + 1].push_back(side.from[i]);
  std::map<int, std::int32_t> start_of;  // by part
  std::vector<std::int32_t> own(crack_starts().size(), -1);
  for (std::int32_t i = 0; i < std::ssize(crack_starts()); ++i) {
    const CrackStart& start = crack_starts()[index(i)];
    if (start.is_free_surface)
      own[index(i)] = i;
    else
      start_of[side_of(start.faces.front()).part] = i;
  }

  std::vector<Symmetry> result;
  for (unsigned axes = 0; axes < 8; ++axes) {
    const Reflection reflection{axes, bounds(), planes, index_.tolerance()};
    std::vector<std::int32_t> images = own;
    const bool is_symmetry = std::ranges::all_of(index_.sides(), [&](const plane::Side& side) {
      const auto image_of = [&](const plane::Point& p) {
        const Point q = reflection({0, p[0], p[1]});
        return plane::Point{q[1], q[2]};
      };
      const plane::Point from = image_of(side.from);
      const plane::Point to = image_of(side.to);
      const auto are_near = [&](const plane::Point& a, const plane::Point& b) {
        return std::abs(a[0] - b[0]) <= index_.tolerance() && std::abs(a[1] - b[1]) <= index_.tolerance();
      };
      const auto image = std::ranges::find_if(index_.sides(), [&](const plane::Side& other) {
        return (are_near(from, other.from) && are_near(to, other.to)) ||
               (are_near(from, other.to) && are_near(to, other.from));
      });
      if (image == index_.sides().end()) return false;
      const auto start = start_of.find(side.part);
      const auto other = start_of.find(image->part);
      if ((start == start_of.end()) != (other == start_of.end())) return false;
      if (start == start_of.end()) return true;
      std::int32_t& image_start = images[index(start->second)];
      if (image_start >= 0 && image_start != other->second) return false;
      image_start = other->second;
      return true;
    });
    if (is_symmetry) result.push_back(reflection.symmetry(std::move(images)));
  }
  return result;
}

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
