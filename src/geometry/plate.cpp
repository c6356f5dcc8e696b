// SPDX-License-Identifier: GPL-3.0-or-later
#include "plate.h"

#include "common/index.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace crackle::geometry {

namespace {

class PlateBuilder {
public:
  explicit PlateBuilder(const plane::Specimen& specimen)
      : specimen_(specimen), shape_(plane::shape_of(specimen)), sides_(plane::sides_of(shape_)) {
    const plane::Bounds bounds = plane::bounds_of(shape_.loops.front().corners);
    complex_.bounds = {at(0, bounds.lower), at(specimen.size[0], bounds.upper)};
    complex_.volume = thickness() * plane::area(shape_);
    for (const plane::Loop& loop : shape_.loops) {
      complex_.outline.push_back(loop.corners);
      for (const plane::Point& p : loop.corners)
        for (const double x : {0.0, thickness()}) complex_.corners.push_back(at(x, p));
    }
    const bool is_box = plane::is_box(specimen);
    add_plane_faces();
    add_walls(is_box);
    add_edges();
    if (is_box)
      add_ligaments();
    else
      add_round_starts();
    complex_.spacing_rules.push_back(plate_spacing(specimen));
  }

  Complex result() { return std::move(complex_); }

private:
  double thickness() const { return complex_.bounds.upper[0]; }

  void add_plane_faces() {
    std::vector<std::array<plane::Point, 2>> rim;
    for (const plane::Side& side : sides_) rim.push_back({side.from, side.to});
    for (const double x : {0.0, thickness()}) {
      Patch patch{complex_.bounds};
      patch.domain.lower[0] = patch.domain.upper[0] = x;
      const bool is_lower = x == 0;
      complex_.faces.push_back({{is_lower ? "x-min" : "x-max"},
                                plane::area(shape_),
                                Vector{is_lower ? -1.0 : 1.0, 0, 0},
                                patch,
                                rim});
    }
  }

  void add_walls(bool is_box) {
    for (std::size_t l = 0; l < shape_.loops.size(); ++l)
      for (std::size_t i = 0; i < shape_.loops[l].size(); ++i) {
        std::vector<std::string> names = plane::names_of_side(shape_, l, i);
        if (is_box) std::ranges::reverse(names);  // an edge of a box is first of all a face
        complex_.faces.push_back(
            wall(sides_[complex_.faces.size() - first_wall], 0, thickness(), std::move(names)));
      }
  }

  void add_edges() {
    for (const plane::Side& side : sides_) {
      complex_.edges.emplace_back(at(0, side.from), at(thickness(), side.from));
      for (const double x : {0.0, thickness()}) complex_.edges.emplace_back(at(x, side.from), at(x, side.to));
    }
  }

  /// The walls of a part of the shape.
  std::vector<FaceId> walls_of(const std::string& part) const {
    std::vector<FaceId> walls;
    for (std::size_t s = 0; s < sides_.size(); ++s)
      if (shape_.parts[index(sides_[s].part)].name == part)
        walls.push_back(static_cast<FaceId>(first_wall + s));
    return walls;
  }

  void add_ligaments() {
    for (std::size_t i = 0; i < specimen_.notches.size(); ++i) {
      const plane::Notch& notch = specimen_.notches[i];
      const auto depth_axis = index(axis_of(notch.face)), at_axis = index(position_axis(notch.face));
      const auto [low, high] = plane::slot_of(notch, bounds_of(specimen_))[depth_axis];
      CrackStart start{};
      start.name = fmt::format("notch {}", i + 1);
      start.tip[0] = thickness() / 2;
      start.tip[at_axis] = notch.at;
      start.tip[depth_axis] = is_upper(notch.face) ? low : high;
      start.end = start.tip;
      start.end[depth_axis] = plane::ligament_end(specimen_, i);
      start.along[depth_axis] = 1;
      start.across[at_axis] = 1;
      start.direction = is_upper(notch.face) ? -1 : 1;
      start.ligament = std::abs(start.end[depth_axis] - start.tip[depth_axis]);
      start.faces = walls_of(fmt::format("notch-{}", i));
      start.reach = notch.height;
      complex_.crack_starts.push_back(std::move(start));
    }
  }

  void add_round_starts() {
    const auto add = [&](const std::string& part, const plane::Point& middle) {
      CrackStart start{};
      start.name = part;
      start.tip = {thickness() / 2, middle[0], middle[1]};
      start.is_straight = false;
      start.faces = walls_of(part);
      complex_.crack_starts.push_back(std::move(start));
    };
    for (std::size_t i = 0; i < specimen_.notches.size(); ++i) {
      const std::string part = fmt::format("notch-{}", i);
      // The mean position of its walls, away from the mouth.
      plane::Point middle{};
      double length = 0;
      for (const FaceId face : walls_of(part)) {
        const plane::Side& side = sides_[index(face) - first_wall];
        for (std::size_t k = 0; k < 2; ++k) middle[k] += side.length * (side.from[k] + side.to[k]) / 2;
        length += side.length;
      }
      for (double& coordinate : middle) coordinate /= length;
      add(part, middle);
    }
    const std::vector<plane::Hole>& holes = specimen_.holes;
    for (std::size_t i = 0; i < holes.size(); ++i) {
      plane::Point middle = holes[i].center;
      if (!holes[i].polygon.empty()) {
        const plane::Bounds around = plane::bounds_of(holes[i].polygon);
        for (std::size_t k = 0; k < 2; ++k) middle[k] = (around.lower[k] + around.upper[k]) / 2;
      }
      add(fmt::format("hole-{}", i), middle);
      complex_.crack_starts.back().is_hole = true;
    }
    const Point centre = complex_.bounds.lower + (complex_.bounds.upper - complex_.bounds.lower) / 2;
    add("free surface", {centre[1], centre[2]});
    complex_.crack_starts.back().is_free_surface = true;
  }

  const plane::Specimen& specimen_;
  plane::Shape shape_;
  std::vector<plane::Side> sides_;
  Complex complex_;
};

}  // namespace

Face wall(const plane::Side& side, double lower, double upper, std::vector<std::string> names) {
  const Patch patch{{{0, 0, 0}, {upper - lower, side.length, 0}},
                    at(lower, side.from),
                    {{{1, 0, 0}, {0, side.along[0], side.along[1]}, {0, -side.along[1], side.along[0]}}}};
  const std::array<plane::Point, 4> corner{
      {{0, 0}, {upper - lower, 0}, {upper - lower, side.length}, {0, side.length}}};
  Face face{std::move(names), (upper - lower) * side.length, Vector{0, side.along[1], -side.along[0]}, patch};
  for (std::size_t i = 0; i < corner.size(); ++i) face.rim.push_back({corner[i], corner[(i + 1) % 4]});
  return face;
}

Complex plate(const plane::Specimen& specimen) {
  return PlateBuilder(specimen).result();
}

}  // namespace crackle::geometry
