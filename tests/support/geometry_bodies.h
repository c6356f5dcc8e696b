// SPDX-License-Identifier: GPL-3.0-or-later
// Small bodies and spacings for tests of the geometry.
#pragma once

#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "input/parameters.h"

#include <string>
#include <utility>
#include <vector>

namespace crackle::testing {

inline constexpr double mm = 1e-3;

inline plane::Notch notch(plane::Face face, double at_mm, double depth_mm, double height_mm) {
  return {.face = face, .at = at_mm * mm, .depth = depth_mm * mm, .height = height_mm * mm};
}

inline geometry::Body body(const Vector& size_mm, std::vector<plane::Notch> notches = {}) {
  return *geometry::make_body(
      plane::Specimen{{size_mm[0] * mm, size_mm[1] * mm, size_mm[2] * mm}, std::move(notches)});
}

inline input::Mesh mesh(double spacing_mm, double notch_spacing_mm, double growth = 0.1) {
  return {.spacing = spacing_mm * mm,
          .notch_spacing = notch_spacing_mm * mm,
          .growth = growth,
          .perturbation = 0.2,
          .min_quality = 0.2,
          .points = {},
          .points_digest = {},
          .regions = {}};
}

/// @param box and spacing in mm
inline input::MeshRegion region(plane::Region box_mm, double spacing_mm) {
  for (auto& [lower, upper] : box_mm) {
    lower *= mm;
    upper *= mm;
  }
  return {box_mm, spacing_mm * mm};
}

/// The plate of the paper, shortened, with its two anti-symmetric notches: about 6,000 nodes with
/// plate_mesh().
inline geometry::Body short_plate() {
  return body({3, 16, 24}, {notch(plane::Face::y_min, 9, 4, 0.6), notch(plane::Face::y_max, 15, 4, 0.6)});
}
inline input::Mesh plate_mesh() {
  return mesh(1.5, 0.3, 0.12);
}

/// The walls and the tip of notch i of a box, and their positions.
struct SlotFaces {
  geometry::FaceId lower_wall, upper_wall, tip_face;
  double lower, upper, tip;  ///< [m]
};
inline SlotFaces slot_faces(const geometry::Body& body, int i) {
  const std::vector<geometry::FaceId> faces = body.faces_named("notch-" + std::to_string(i));
  const Vector& across = body.crack_starts()[index(i)].across;
  const auto at_axis = index(across[1] != 0 ? 1 : 2), depth_axis = 3 - at_axis;
  const auto position = [&](geometry::FaceId id, std::size_t axis) {
    return body.faces()[index(id)].patch.origin[axis];
  };
  SlotFaces slot{faces.at(0), faces.at(2), faces.at(1), 0, 0, position(faces.at(1), depth_axis)};
  if (body.faces()[index(slot.lower_wall)].outward[at_axis] < 0) std::swap(slot.lower_wall, slot.upper_wall);
  slot.lower = position(slot.lower_wall, at_axis);
  slot.upper = position(slot.upper_wall, at_axis);
  return slot;
}

/// A notch in each of the four possible faces.
inline geometry::Body four_notches() {
  return body({2, 10, 12}, {notch(plane::Face::y_min, 6, 2, 0.5), notch(plane::Face::y_max, 5, 3, 0.8),
                            notch(plane::Face::z_min, 5, 2, 0.4), notch(plane::Face::z_max, 4, 1, 1.5)});
}

}  // namespace crackle::testing
