// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/input/material_layout.h"
#include "crackle/plane/side_index.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace crackle::geometry {

/// A plate of several materials: its layers are parted by walls along x, and by caps normal to x between
/// them. Both are inner faces, with edges and corners where they meet each other and the surface.
///
/// An inner wall is a rectangle through one layer; where it goes on in the next one, points move across their
/// common border. All caps at one x are one face, with gaps. Points on caps have exactly equal x, points on
/// walls are on them within the tolerance of the plate's walls.
class CompositeBody final : public Body {
public:
  /// @param plain the extruded plate of the specimen
  /// @throws std::runtime_error as input::material_layout
  CompositeBody(std::unique_ptr<const Body> plain, const input::Specimen& specimen,
                std::vector<std::array<int, 2>> interfaces = {});

  int material_at(const Point& p) const override;
  bool contains(const Point& p) const override { return plain_->contains(p); }
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
  struct Layer {
    double lower, upper;     ///< x [m]
    plane::SideIndex walls;  ///< their part is the line of the layout
    Box around;              ///< the walls, including the tolerance
  };
  struct Cap {
    double x;
    plane::SideIndex rim;      ///< around all that is part of the cap
    plane::SideIndex borders;  ///< these sides, and the walls that end on the cap
  };
  /// An inner face: side `part` of a layer's walls, or the cap at a level.
  struct InnerFace {
    bool is_cap;
    std::size_t number;  ///< of the layer or the cap
    std::size_t side;    ///< number among the layer's walls
  };
  /// A region's outline, divided as the lines are.
  struct Outline {
    plane::Bounds bounds;
    plane::SideIndex sides;
  };
  /// An edge on a wall of the surface, in its own coordinates: x, and the distance along the wall.
  using OwnLine = std::array<plane::Point, 2>;
  class Edges;

  void add_walls();
  void add_caps();
  void add_volumes();
  bool is_in_cap(const input::MaterialLayout::Line& line, std::size_t level, bool on_left) const;
  plane::Side side_of(const input::MaterialLayout::Line& line, std::size_t number) const;
  const InnerFace* inner(FaceId face) const {
    return index(face) < faces().size() ? nullptr : &inner_[index(face) - faces().size()];
  }
  const plane::Side& wall(const InnerFace& face) const {
    return layers_[face.number].walls.sides()[face.side];
  }
  /// Calls visit(side) for each inner wall that a point is on.
  template <class Visit>
  void for_walls_at(const Point& p, Visit&& visit) const;
  bool is_on_cap(const Cap& cap, const Point& p) const {
    return p[0] == cap.x && cap.rim.contains({p[1], p[2]});
  }
  bool crosses(const Layer& layer, const std::array<Point, 4>& corners) const;
  bool crosses(const Cap& cap, const std::array<Point, 4>& corners) const;
  std::optional<Point> passage_of_wall(const InnerFace& face, const Point& p, const Point& q,
                                       double margin) const;
  std::optional<Point> passage_of_cap(const Cap& cap, const Point& p, const Point& q, double margin) const;
  std::string region_name(std::size_t line) const;
  void add_wall_sources(const input::Mesh& mesh, std::vector<SpacingSource>& sources) const;
  void add_cap_sources(const input::Mesh& mesh, std::vector<SpacingSource>& sources) const;
  bool maps_materials(const Symmetry& symmetry) const;

  std::unique_ptr<const Body> plain_;
  input::MaterialLayout layout_;
  double tolerance_;
  plane::Bounds plane_bounds_;
  std::vector<plane::Side> plate_sides_;
  std::vector<bool> is_curve_;  ///< of each region
  std::vector<Layer> layers_;
  std::vector<Cap> caps_;
  std::vector<Outline> outlines_;
  std::vector<InnerFace> inner_;
  std::vector<std::vector<OwnLine>> on_side_;  ///< edges within each side of the plate
};

}  // namespace crackle::geometry
