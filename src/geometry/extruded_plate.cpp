// SPDX-License-Identifier: GPL-3.0-or-later
#include "extruded_plate.h"
#include "plane_directions.h"
#include "reflection.h"

#include <algorithm>
#include <utility>

namespace crackle::geometry {

namespace {

double largest_size(const input::Specimen& specimen) {
  return *std::ranges::max_element(specimen.size);
}

}  // namespace

ExtrudedPlate::ExtrudedPlate(const input::Specimen& specimen)
    : plate_(input::shape_of(specimen)),
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
  const bool is_box = input::is_box(specimen);
  add_faces(is_box);
  add_edges();
  if (is_box)
    add_ligaments();
  else
    add_round_starts(specimen.holes);
}

void ExtrudedPlate::add_faces(bool is_box) {
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
      if (is_box) std::ranges::reverse(names);  // an edge of a box is first of all a face
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

}  // namespace crackle::geometry
