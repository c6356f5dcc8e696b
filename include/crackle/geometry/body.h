// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstdint>
#include <string>
#include <vector>

namespace crackle::geometry {

struct Box {
  Point lower;
  Point upper;
};

/// Number of a plane piece of the body's surface: 0..5 are the faces of the box in the order of input::Face;
/// notch i has the numbers 6 + 3 i (lower wall), 7 + 3 i (upper wall) and 8 + 3 i (tip).
using SurfaceId = std::int32_t;

/// A plane piece of the surface: coordinate `axis` equals `position`.
struct Surface {
  int axis;
  double position;
  double area;     ///< exact area that belongs to the body's boundary [m^2]
  double outward;  ///< +1 or -1: direction of the outward normal along `axis`
};

/// The exact geometry of the notched box that every realization must fill.
class Body {
public:
  /// @pre the specimen passed the reader's checks: notches lie inside the box and do not touch each other
  explicit Body(input::Specimen specimen);

  const Point& size() const { return specimen_.size; }
  int n_notches() const { return static_cast<int>(specimen_.notches.size()); }
  const input::Notch& notch(int i) const { return specimen_.notches[static_cast<std::size_t>(i)]; }

  /// The closed box that notch i removes.
  const Box& slot(int i) const { return slots_[static_cast<std::size_t>(i)]; }
  const std::vector<Surface>& surfaces() const { return surfaces_; }
  double volume() const { return volume_; }  ///< [m^3]

  /// The notch whose walls or tip carry this surface id, or -1.
  static int notch_of(SurfaceId id) { return id < 6 ? -1 : (id - 6) / 3; }

  /// Distance from p to the tip (the bottom face of the slot) of the nearest notch [m]; infinity without
  /// notches.
  double distance_to_notch_tip(const Point& p) const;

private:
  input::Specimen specimen_;
  std::vector<Box> slots_;
  std::vector<Surface> surfaces_;
  double volume_ = 0;
};

}  // namespace crackle::geometry
