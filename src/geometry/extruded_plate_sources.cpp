// SPDX-License-Identifier: GPL-3.0-or-later
// Spacing sources and symmetries of an extruded plate.
#include "crackle/geometry/mother_points.h"
#include "extruded_plate.h"
#include "reflection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

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

std::vector<SpacingSource> ExtrudedPlate::spacing_sources(const input::Mesh& mesh) const {
  std::vector<SpacingSource> sources;
  const double far = mesh.spacing;
  const double shape = shape_growth(mesh);
  const auto add = [&](const plane::Point& from, const plane::Point& to, double spacing, double growth,
                       std::string reason) {
    Box box{{0, std::min(from[0], to[0]), std::min(from[1], to[1])},
            {thickness(), std::max(from[0], to[0]), std::max(from[1], to[1])}};
    SpacingSource source{box, spacing, growth, std::move(reason)};
    if (from[0] != to[0] && from[1] != to[1]) source.wall = {from, to};
    sources.push_back(std::move(source));
  };

  // The walls at the tips of slots: those of a half circle or a rectangle at the end.
  for (std::size_t i = 0; i < notches_.size(); ++i) {
    const input::Notch& notch = notches_[i];
    const std::vector<plane::Point> ends = notch_ends(notch, bounds());
    for (const FaceId face : faces_named(fmt::format("notch-{}", i))) {
      const plane::Side& side = side_of(face);
      const auto is_near = [&](const plane::Point& end, const plane::Point& p) {
        return plane::norm({p[0] - end[0], p[1] - end[1]}) <= 0.7072 * notch.height;
      };
      if (std::ranges::any_of(ends, [&](const plane::Point& end) {
            return is_near(end, side.from) && is_near(end, side.to);
          }))
        add(side.from, side.to, mesh.notch_spacing, mesh.growth,
            fmt::format("notch_spacing at notch {}", i + 1));
    }
  }

  const std::vector<SpacingSource> regions = region_sources(mesh, bounds());
  const auto spacing_at = [&](const plane::Point& p) {
    const Point place{thickness() / 2, p[0], p[1]};
    double spacing = far;
    for (const SpacingSource& source : regions) spacing = std::min(spacing, source.at(place));
    for (const SpacingSource& source : sources) spacing = std::min(spacing, source.at(place));
    return spacing;
  };
  // The length of a wall, and the distance of others to each piece of it.
  const auto& sides = index_.sides();
  for (std::size_t s = 0; s < sides.size(); ++s) {
    const plane::Side& side = sides[s];
    const std::string name = faces()[first_wall + s].names.front();
    const auto wants = [&](const plane::Point& from, const plane::Point& to, double spacing,
                           const std::string& reason) {
      const plane::Point middle{(from[0] + to[0]) / 2, (from[1] + to[1]) / 2};
      if (spacing * fine_enough < spacing_at(middle)) add(from, to, spacing, shape, reason);
    };
    wants(side.from, side.to, side.length, fmt::format("the length of {}", name));
    const double n_pieces = std::clamp(std::ceil(side.length / far), 1.0, 1000.0);
    const auto place = [&](double piece) {
      const double way = piece / n_pieces * side.length;
      return piece == n_pieces
                 ? side.to
                 : plane::Point{side.from[0] + way * side.along[0], side.from[1] + way * side.along[1]};
    };
    for (double piece = 0; piece < n_pieces; ++piece) {
      const plane::Point from = place(piece);
      const plane::Point to = place(piece + 1);
      double gap = far;
      for (std::size_t other = 0; other < sides.size(); ++other) {
        const plane::Side& wall = sides[other];
        const bool is_neighbour = other == s || wall.from == side.to || wall.to == side.from;
        const bool same_curve = wall.part == side.part && plate_.parts[index(side.part)].is_curve;
        if (is_neighbour || same_curve) continue;
        gap = std::min(gap, plane::distance(from, to, wall.from, wall.to));
      }
      if (gap < far) wants(from, to, gap, fmt::format("what is near {}", name));
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
  std::map<std::string, std::int32_t> start_of;  // by part
  for (std::size_t i = 0; i + 1 < crack_starts().size(); ++i)
    start_of[plate_.parts[index(side_of(crack_starts()[i].faces.front()).part)].name] =
        static_cast<std::int32_t>(i);

  std::vector<Symmetry> result;
  for (unsigned axes = 0; axes < 8; ++axes) {
    const Reflection reflection{axes, bounds(), planes, index_.tolerance()};
    std::vector<std::int32_t> images(crack_starts().size(), -1);
    images.back() = static_cast<std::int32_t>(images.size()) - 1;
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
      const auto start = start_of.find(plate_.parts[index(side.part)].name);
      const auto other = start_of.find(plate_.parts[index(image->part)].name);
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

}  // namespace crackle::geometry
