// SPDX-License-Identifier: GPL-3.0-or-later
// Where the shape of a plate requires a finer mesh.
#include "geometry/mother_points.h"
#include "plate.h"
#include "tolerances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>

namespace crackle::geometry {

namespace {

/// Both ends of a free slot, or the tip of a notch in a face.
std::vector<plane::Point> notch_ends(const plane::Notch& notch, const Box& bounds) {
  if (notch.slot) return {notch.slot->from, notch.slot->to};
  const std::size_t depth_axis = index(axis_of(notch.face));
  plane::Point tip{};
  tip[depth_axis - 1] =
      is_upper(notch.face) ? bounds.upper[depth_axis] - notch.depth : bounds.lower[depth_axis] + notch.depth;
  tip[index(position_axis(notch.face)) - 1] = notch.at;
  return {tip};
}

/// The sources of refinement of one plate.
class PlateSpacing {
public:
  explicit PlateSpacing(const plane::Specimen& specimen)
      : plate_(plane::shape_of(specimen)),
        index_(plate_, wall_tolerance * std::ranges::max(specimen.size)),
        notches_(specimen.notches),
        thickness_(specimen.size[0]),
        is_box_(plane::is_box(specimen)) {
    const plane::Bounds bounds = plane::bounds_of(plate_.loops.front().corners);
    bounds_ = {at(0, bounds.lower), at(thickness_, bounds.upper)};
    for (std::size_t l = 0; l < plate_.loops.size(); ++l)
      for (std::size_t i = 0; i < plate_.loops[l].size(); ++i) {
        const std::vector<std::string> names = plane::names_of_side(plate_, l, i);
        names_.push_back(is_box_ ? names.back() : names.front());
      }
  }

  void add_sources(const input::Mesh& mesh, std::vector<SpacingSource>& sources) const {
    sources = tip_sources(mesh);
    const double far = mesh.spacing;
    // Walls are compared with these alone: of two close walls both refine the mesh, whichever comes first.
    // Chords are compared with those of their own curve too, as each would be a source otherwise.
    std::vector<SpacingSource> given = region_sources(mesh, bounds_);
    given.insert(given.end(), sources.begin(), sources.end());
    bool is_chord = false;
    std::size_t own_curve = 0;  // the first source of a chord's curve
    const auto is_finer = [&](double wanted, const plane::Point& from, const plane::Point& to) {
      const Point middle{thickness_ / 2, (from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
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
      if (is_finer(side.length, side.from, side.to))
        add(side.from, side.to, side.length, reason_for_length(s));
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
  }

private:
  SpacingSource wall_source(const plane::Point& from, const plane::Point& to, double spacing, double growth,
                            std::string reason) const {
    const Box box{{0, std::min(from[0], to[0]), std::min(from[1], to[1])},
                  {thickness_, std::max(from[0], to[0]), std::max(from[1], to[1])}};
    SpacingSource source{box, spacing, growth, std::move(reason)};
    if (from[0] != to[0] && from[1] != to[1]) source.wall = {from, to};
    return source;
  }

  /// The walls at the tips of slots: those of a half circle or a rectangle at the end.
  std::vector<SpacingSource> tip_sources(const input::Mesh& mesh) const {
    std::vector<SpacingSource> sources;
    for (std::size_t i = 0; i < notches_.size(); ++i) {
      const plane::Notch& notch = notches_[i];
      const std::vector<plane::Point> ends = notch_ends(notch, bounds_);
      // The corners of a square end are half a height away, those of a round one at most 1 / sqrt(2) heights.
      const bool is_round = notch.slot && notch.slot->end == plane::SlotEnd::round;
      const double reach = (is_round ? 0.7072 : 0.5001) * notch.height;
      const std::string part = fmt::format("notch-{}", i);
      for (const plane::Side& side : index_.sides()) {
        if (plate_.parts[index(side.part)].name != part) continue;
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

  std::string name_in_messages(std::size_t side) const {
    const std::string& name = names_[side];
    if (name.starts_with("notch-")) return fmt::format("notch {}", std::stoi(name.substr(6)) + 1);
    return std::ranges::find(plane::face_names, name) == plane::face_names.end() ? name : "the face " + name;
  }

  std::string reason_for_length(std::size_t side) const {
    const bool is_whole =
        std::ranges::count(index_.sides(), index_.sides()[side].part, &plane::Side::part) == 1;
    return fmt::format("the length of {}{}", is_whole ? "" : "a side of ", name_in_messages(side));
  }

  std::string reason_for_gap(std::size_t side, std::size_t other) const {
    const std::string name = name_in_messages(side);
    const std::string other_name = name_in_messages(other);
    if (name != other_name) return fmt::format("the distance between {} and {}", name, other_name);
    const bool is_slot = name.starts_with("notch") && is_box_;
    return fmt::format("the {} of {}", is_slot ? "height" : "shape", name);
  }

  /// For each side the others whose distance to it counts.
  std::vector<std::vector<std::size_t>> facing_sides() const {
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
        // A wall beside a slot's mouth is close to those across it only through the slot, which does not
        // count.
        const bool across_mouth = std::ranges::any_of(
            mouths[a], [&](int slot) { return sides[b].part == slot || mouths[b].contains(slot); });
        if (a != b && !are_neighbours(a, b) && !same_curve && !across_mouth) facing[a].push_back(b);
      }
    return facing;
  }

  plane::Shape plate_;
  plane::SideIndex index_;
  std::vector<plane::Notch> notches_;
  double thickness_;
  bool is_box_;
  Box bounds_;
  std::vector<std::string> names_;  ///< of each side, in messages
};

}  // namespace

SpacingRule plate_spacing(const plane::Specimen& specimen) {
  return [spacing = std::make_shared<const PlateSpacing>(specimen)](const Body&, const input::Mesh& mesh,
                                                                    std::vector<SpacingSource>& sources) {
    spacing->add_sources(mesh, sources);
  };
}

}  // namespace crackle::geometry
