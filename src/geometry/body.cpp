// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/body.h"

#include "extruded_plate.h"

#include <stdexcept>

namespace crackle::geometry {

Point Patch::at(const Point& own) const {
  return origin + own[0] * axes[0] + own[1] * axes[1] + own[2] * axes[2];
}

Point Patch::own(const Point& p) const {
  const Vector offset = p - origin;
  return {dot(offset, axes[0]), dot(offset, axes[1]), dot(offset, axes[2])};
}

Box Patch::bounds(const Box& own) const {
  Box box{origin, origin};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({own.lower[k] * axes[k][i], own.upper[k] * axes[k][i]});
      box.lower[i] += low;
      box.upper[i] += high;
    }
  return box;
}

Edge::Edge(const Point& from, const Point& to)
    : from_(from), to_(to), length_(norm(to - from)), direction_((to - from) / length_) {}

Point Edge::at(double length) const {
  return from_ + length * direction_;
}

Box Edge::bounds() const {
  Box box{from_, from_};
  box.include(to_);
  return box;
}

std::vector<FaceId> Body::faces_named(const std::string& name) const {
  std::vector<FaceId> ids;
  for (std::size_t id = 0; id < faces().size(); ++id)
    if (std::ranges::find(faces()[id].names, name) != faces()[id].names.end())
      ids.push_back(static_cast<FaceId>(id));
  return ids;
}

FaceId Body::face_of(const std::array<Point, 3>& corners) const {
  for (std::size_t id = 0; id < faces().size(); ++id)
    if (std::ranges::all_of(corners, [&](const Point& p) { return in_face(static_cast<FaceId>(id), p); }))
      return static_cast<FaceId>(id);
  throw std::runtime_error("realization: a boundary triangle lies in no face of the body");
}

std::unique_ptr<const Body> make_body(const input::Specimen& specimen) {
  return std::make_unique<ExtrudedPlate>(specimen);
}

}  // namespace crackle::geometry
