// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <vector>

namespace crackle::geometry {

/// The cross-section of a notch's slot, constant over the thickness x: the rectangle from `lower` to `upper`
/// along axis `at_axis`, from the face to `tip` along axis `depth_axis`.
struct SlotSection {
  int at_axis;
  int depth_axis;
  double lower, upper;  ///< the two walls [m]
  double mouth, tip;    ///< coordinate of the face and of the tip along depth_axis [m]
};

/// A box with its lower corner at the origin, and slots cut into its faces.
///
/// Lengths are used unmodified, so that walls, tips and faces are planes with a single double as coordinate.
/// Faces 0..5 are those of the box in the order of input::Face; notch i has the faces 6 + 3 i (lower wall), 7
/// + 3 i (upper wall) and 8 + 3 i (tip). A crack starts at each notch's tip.
class NotchedBox final : public Body {
public:
  /// @throws std::runtime_error naming the notch and the reason when a notch is not a slot inside its face,
  ///   reaches or passes the opposite face, or touches another notch
  explicit NotchedBox(const input::Specimen& specimen);

  const std::vector<SlotSection>& sections() const { return sections_; }  ///< of all notches
  /// The closed box removed by notch i.
  const Box& slot(int i) const { return slots_[index(i)]; }

  bool contains(const Point& p) const override;
  bool in_face(FaceId face, const Point& p) const override {
    return faces()[index(face)].patch.domain.contains(p);
  }
  std::uint8_t movable(const Point& p) const override;
  Directions directions(const Point& p, std::uint8_t movable) const override;
  double distance_to_surface(const Point& p) const override;
  double distance_to_outline(FaceId face, const Point& p) const override;
  std::optional<Point> passage(FaceId face, const Point& p, const Point& q, double margin) const override;
  Point snapped(const Point& p, double tolerance) const override;
  Place place(const std::array<Point, 4>& corners) const override;
  std::vector<SpacingSource> spacing_sources(const input::Mesh& mesh) const override;
  std::vector<Symmetry> symmetries() const override;

private:
  void cut_slots();
  void add_faces();
  void add_face(std::string name, const Box& box, int axis, double position, double outward);
  void add_edges();
  void add_corners();
  void add_crack_starts();
  void add_outline();

  std::vector<input::Notch> notches_;
  std::vector<SlotSection> sections_;
  std::vector<Box> slots_;
  std::vector<int> axis_;  ///< normal axis of each face
};

}  // namespace crackle::geometry
