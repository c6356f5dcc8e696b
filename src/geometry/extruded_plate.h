// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"
#include "crackle/plane/shape.h"
#include "crackle/plane/side_index.h"

#include <array>
#include <string>
#include <vector>

namespace crackle::geometry {

/// A plane shape extruded along x from 0 to the thickness.
///
/// Faces 0 and 1 are x-min and x-max, face 2 + s is the wall on side s of the shape. Points on x-min, x-max
/// and walls normal to y or z have exactly equal coordinates; coordinates of points on other walls are
/// rounded, so there a point is on a wall, an edge or a corner within a tolerance of 1e-12 of the body's
/// size. Tetrahedra with all corners on one wall are flat up to rounding and not part of the body.
///
/// In a box, cracks start at the tips of its slots and are followed along their ligaments. In other plates
/// they start, in any direction, at each notch, at each hole and on the free surface.
class ExtrudedPlate final : public Body {
public:
  /// @pre specimen.shape is consistent with the other members of the specimen
  /// @throws std::runtime_error as input::shape_of
  explicit ExtrudedPlate(const input::Specimen& specimen);

  bool contains(const Point& p) const override;
  bool in_face(FaceId face, const Point& p) const override;
  std::uint8_t movable(const Point& p) const override;
  Directions directions(const Point& p, std::uint8_t movable) const override;
  double distance_to_surface(const Point& p) const override;
  double distance_to_outline(FaceId face, const Point& p) const override;
  std::optional<Point> passage(FaceId face, const Point& p, const Point& q, double margin) const override;
  Point snapped(const Point& p, double tolerance) const override;
  Containment classify(const std::array<Point, 4>& corners) const override;
  std::vector<SpacingSource> spacing_sources(const input::Mesh& mesh) const override;
  std::vector<Symmetry> symmetries() const override;

private:
  static constexpr std::size_t first_wall = 2;  ///< face of side 0

  void add_faces(bool is_box);
  void add_edges();
  void add_ligaments();
  void add_round_starts(const std::vector<input::Hole>& holes);
  SpacingSource wall_source(const plane::Point& from, const plane::Point& to, double spacing, double growth,
                            std::string reason) const;
  std::vector<SpacingSource> tip_sources(const input::Mesh& mesh) const;
  std::vector<std::vector<std::size_t>> facing_sides() const;
  std::string name_in_messages(std::size_t side) const;  ///< such as "notch 1", "the face y-min", "hole-0"
  std::string reason_for_length(std::size_t side) const;
  std::string reason_for_gap(std::size_t side, std::size_t other) const;
  double thickness() const { return bounds().upper[0]; }
  const plane::Side& side_of(FaceId face) const { return index_.sides()[index(face) - first_wall]; }

  plane::Shape plate_;
  plane::SideIndex index_;
  std::vector<input::Notch> notches_;
};

}  // namespace crackle::geometry
