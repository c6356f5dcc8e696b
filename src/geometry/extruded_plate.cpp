// SPDX-License-Identifier: GPL-3.0-or-later
#include "extruded_plate.h"
#include "reflection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace crackle::geometry {

namespace {

const plane::Shape& shape_of(const input::Specimen& specimen) {
  if (!specimen.shape) throw std::invalid_argument("specimen: the shape of the plate is not known");
  return *specimen.shape;
}

double largest_size(const input::Specimen& specimen) {
  return *std::ranges::max_element(specimen.size);
}

Point at(double x, const plane::Point& p) {
  return {x, p[0], p[1]};
}

}  // namespace

ExtrudedPlate::ExtrudedPlate(const input::Specimen& specimen)
    : plate_(shape_of(specimen)),
      index_(plate_, wall_tolerance * largest_size(specimen)),
      notches_(specimen.notches) {
  const plane::Bounds bounds = plane::bounds_of(plate_.loops.front().corners);
  shape_.bounds = {at(0, bounds.lower), at(specimen.size[0], bounds.upper)};
  shape_.volume = thickness() * plane::area(plate_);
  for (const plane::Loop& loop : plate_.loops) {
    shape_.outline.push_back(loop.corners);
    for (const plane::Point& p : loop.corners)
      for (const double x : {0.0, thickness()}) shape_.corners.push_back(at(x, p));
  }
  add_faces();
  add_edges();
  add_crack_starts(specimen);
}

void ExtrudedPlate::add_faces() {
  for (const double x : {0.0, thickness()}) {
    Patch patch{bounds()};
    patch.domain.lower[0] = patch.domain.upper[0] = x;
    const bool is_lower = x == 0;
    shape_.faces.push_back(
        {{is_lower ? "x-min" : "x-max"}, plane::area(plate_), Vector{is_lower ? -1.0 : 1.0, 0, 0}, patch});
  }
  for (std::size_t l = 0; l < plate_.loops.size(); ++l)
    for (std::size_t i = 0; i < plate_.loops[l].size(); ++i) {
      const plane::Side& side = index_.sides()[shape_.faces.size() - first_wall];
      std::vector<std::string> names = plane::names_of_side(plate_, l, i);
      const auto& part = plate_.loops[l].part;
      if (std::ranges::count(part, part[i]) > 1)
        names.insert(names.begin(), fmt::format("{} side {}", names[0], i));
      Patch patch{{{0, 0, 0}, {thickness(), side.length, 0}},
                  at(0, side.from),
                  {{{1, 0, 0}, {0, side.along[0], side.along[1]}, {0, -side.along[1], side.along[0]}}}};
      shape_.faces.push_back(
          {std::move(names), thickness() * side.length, Vector{0, side.along[1], -side.along[0]}, patch});
    }
}

void ExtrudedPlate::add_edges() {
  for (const plane::Side& side : index_.sides()) {
    shape_.edges.emplace_back(at(0, side.from), at(thickness(), side.from));
    for (const double x : {0.0, thickness()}) shape_.edges.emplace_back(at(x, side.from), at(x, side.to));
  }
}

void ExtrudedPlate::add_crack_starts(const input::Specimen& specimen) {
  const auto add = [&](const std::string& part, const plane::Point& middle) {
    CrackStart start{};
    start.name = part;
    start.tip = at(thickness() / 2, middle);
    start.is_straight = false;
    start.faces = faces_named(part);
    shape_.crack_starts.push_back(std::move(start));
  };
  for (std::size_t i = 0; i < specimen.notches.size(); ++i) {
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
  for (std::size_t i = 0; i < specimen.holes.size(); ++i) {
    const input::Hole& hole = specimen.holes[i];
    plane::Point middle = hole.center;
    if (!hole.polygon.empty()) {
      const plane::Bounds around = plane::bounds_of(hole.polygon);
      for (std::size_t k = 0; k < 2; ++k) middle[k] = (around.lower[k] + around.upper[k]) / 2;
    }
    add(fmt::format("hole-{}", i), middle);
  }
  const Point centre = bounds().lower + size() / 2;
  add("free surface", {centre[1], centre[2]});
  shape_.crack_starts.back().is_free_surface = true;
}

}  // namespace crackle::geometry
