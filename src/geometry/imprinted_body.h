// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/condition_region.h"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace crackle::geometry {

/// Corners closer than this share of the body's size are merged.
inline constexpr double merging_share = 1e-6;

/// A body with the borders of loaded and constrained regions imprinted on its faces. Each border is an edge
/// between corners, like those of the body: it has its own points, which move only along it, and no boundary
/// triangle crosses it. Thus in every realization a region is a union of whole boundary triangles, or of
/// whole edges.
///
/// Faces are those of the body, undivided; lines are parallel to the own axes of the faces.
class ImprintedBody final : public Body {
public:
  /// True if any region is smaller than a whole face.
  static bool is_needed(const Body& plain, std::span<const ConditionRegion> regions);

  /// @param regions of the conditions of the input, in their order
  ImprintedBody(std::unique_ptr<const Body> plain, std::span<const ConditionRegion> regions);

  /// The conditions whose regions make the mesh finer than it would be without them.
  std::vector<RegionRefinement> refinements(const input::Mesh& mesh) const;

  int material_at(const Point& p) const override { return plain_->material_at(p); }
  bool contains(const Point& p) const override { return plain_->contains(p); }
  bool in_face(FaceId face, const Point& p) const override { return plain_->in_face(face, p); }
  std::uint8_t movable(const Point& p) const override;
  Directions directions(const Point& p, std::uint8_t movable) const override {
    return plain_->directions(p, movable);
  }
  double distance_to_surface(const Point& p) const override { return plain_->distance_to_surface(p); }
  double distance_to_outline(FaceId face, const Point& p) const override;
  std::optional<Point> passage(FaceId face, const Point& p, const Point& q, double margin) const override;
  Point snapped(const Point& p, double tolerance) const override;
  Containment classify(const std::array<Point, 4>& corners) const override;
  std::vector<SpacingSource> spacing_sources(const input::Mesh& mesh) const override;
  std::vector<Symmetry> symmetries() const override;

private:
  /// A straight piece of a border between two corners, or one corner within a face.
  struct Line {
    std::array<Point, 2> end;
    std::array<plane::Point, 2> own;  ///< its ends in the own coordinates that span the face
    std::size_t across;               ///< the own coordinate (0 or 1) that is constant along it
    std::uint8_t movable;             ///< remaining freedom of a point on it
    std::size_t condition;            ///< whose border it is
  };
  /// The lines of one face.
  struct Imprint {
    FaceId face;
    std::array<std::size_t, 2> axis;  ///< own axes that span the face
    Box bounds;                       ///< bounding box of its lines, including the tolerance
    std::vector<Line> lines;
  };
  /// A piece of a line that requires a finer mesh than the rest.
  struct LineSource {
    std::size_t condition;
    SpacingSource source;
  };
  class Imprinting;

  const Patch& patch(const Imprint& imprint) const { return faces()[index(imprint.face)].patch; }
  plane::Point own(const Imprint& imprint, const Point& p) const;
  const Imprint* on(FaceId face) const;
  bool is_on(const Line& line, const Point& p) const;
  bool crosses(const Imprint& imprint, const std::array<plane::Point, 3>& triangle) const;
  std::vector<LineSource> line_sources(const input::Mesh& mesh) const;

  std::unique_ptr<const Body> plain_;
  double tolerance_;
  std::vector<Imprint> imprints_;
  std::vector<Point> new_corners_;  ///< in addition to those of the plain body
};

}  // namespace crackle::geometry
