// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <vector>

namespace crackle::geometry {

/// The closed box lower <= p <= upper, by coordinate.
struct Box {
  Point lower;
  Point upper;
  bool contains(const Point& p) const {
    return lower[0] <= p[0] && p[0] <= upper[0] && lower[1] <= p[1] && p[1] <= upper[1] && lower[2] <= p[2] &&
           p[2] <= upper[2];
  }
};

/// Euclidean distances [m]; 0 where the sets meet.
double distance(const Point& p, const Box& box);
double distance(const Box& a, const Box& b);

/// Number of a plane piece of the body's surface: 0..5 are the faces of the box in the order of input::Face;
/// notch i has the numbers 6 + 3 i (lower wall), 7 + 3 i (upper wall) and 8 + 3 i (tip).
using SurfaceId = std::int32_t;

/// A plane piece of the surface: coordinate `axis` equals `position`, bit by bit.
struct Surface {
  int axis;
  double position;  ///< [m]
  double area;      ///< exact area that belongs to the body's boundary [m^2]
  double outward;   ///< +1 or -1: direction of the outward normal along `axis`
  Box extent;  ///< the rectangle of the piece, flat along `axis`; a face's rectangle includes notch openings
};

/// A straight edge of the body between two of its corners, along `axis`.
struct Edge {
  int axis;
  Point from;
  Point to;  ///< equals `from` except in coordinate `axis`, where it is larger
};

/// The slot of a notch as its cross-section, which is the same through the whole thickness x: the rectangle
/// from `lower` to `upper` along axis `at_axis`, from the face to `tip` along axis `depth_axis`.
struct SlotSection {
  int at_axis;
  int depth_axis;
  double lower, upper;  ///< the two walls [m]
  double mouth, tip;    ///< coordinate of the face and of the tip along depth_axis [m]
};

/// The exact geometry of the notched box that every realization must fill.
///
/// The box has its lower corner in the origin. Lengths are used as they are, so that walls, tips and faces
/// are planes whose coordinate is one double.
class Body {
public:
  /// @throws std::runtime_error naming the notch and the reason when a notch is not a slot inside its face,
  ///   reaches or passes the opposite face, or touches another notch
  explicit Body(input::Specimen specimen);

  const Point& size() const { return specimen_.size; }  ///< [m]
  int n_notches() const { return static_cast<int>(specimen_.notches.size()); }
  const input::Notch& notch(int i) const { return specimen_.notches[index(i)]; }

  /// The closed box that notch i removes.
  const Box& slot(int i) const { return slots_[index(i)]; }
  const std::vector<SlotSection>& sections() const { return sections_; }  ///< of all notches
  /// In the order of SurfaceId.
  const std::vector<Surface>& surfaces() const { return surfaces_; }
  /// Every edge of the body once: those of the box outside the notch openings, and those of the notches.
  std::vector<Edge> edges() const;
  /// 8 of the box and 8 of each notch.
  std::vector<Point> corners() const;
  double volume() const { return volume_; }  ///< [m^3]

  /// The notch whose walls or tip carry this surface id, or -1.
  static int notch_of(SurfaceId id) { return id < 6 ? -1 : (id - 6) / 3; }

  /// Distance from p to the tip (the bottom face of the slot) of the nearest notch [m]; infinity without
  /// notches.
  double distance_to_notch_tip(const Point& p) const;

  /// True in the body and on its surface.
  bool contains(const Point& p) const;

  /// The coordinates of a point of the body that can change without leaving its surfaces: bit i is clear
  /// where the point lies, bit by bit, on a plane piece across axis i. So 7 in the interior, one bit less on
  /// a face, two on an edge, 0 at a corner.
  /// @pre contains(p)
  std::uint8_t movable_axes(const Point& p) const;

  /// Distance from a point of the body to its surface [m].
  double distance_to_surface(const Point& p) const;

private:
  input::Specimen specimen_;
  std::vector<Box> slots_;
  std::vector<SlotSection> sections_;
  std::vector<Surface> surfaces_;
  double volume_ = 0;
};

}  // namespace crackle::geometry
