// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"

#include <stdexcept>

namespace crackle::test {

/// A body that only has the fixed data of an instance, which is all that the analysis needs; other members
/// throw.
class BodyOfShape : public geometry::Body {
public:
  bool contains(const geometry::Point&) const override { return refuse(), false; }
  bool in_face(geometry::FaceId, const geometry::Point&) const override { return refuse(), false; }
  std::uint8_t movable(const geometry::Point&) const override { return refuse(), 0; }
  geometry::Directions directions(const geometry::Point&, std::uint8_t) const override {
    return refuse(), geometry::Directions{};
  }
  double distance_to_surface(const geometry::Point&) const override { return refuse(), 0; }
  double distance_to_outline(geometry::FaceId, const geometry::Point&) const override { return refuse(), 0; }
  std::optional<geometry::Point> passage(geometry::FaceId, const geometry::Point&, const geometry::Point&,
                                         double) const override {
    return refuse(), std::nullopt;
  }
  geometry::Point snapped(const geometry::Point&, double) const override {
    return refuse(), geometry::Point{};
  }
  geometry::Containment classify(const std::array<geometry::Point, 4>&) const override {
    return refuse(), geometry::Containment::inside;
  }
  std::vector<geometry::SpacingSource> spacing_sources(const input::Mesh&) const override {
    return refuse(), std::vector<geometry::SpacingSource>{};
  }
  std::vector<geometry::Symmetry> symmetries() const override {
    return refuse(), std::vector<geometry::Symmetry>{};
  }

private:
  static void refuse() { throw std::logic_error("a question that the analysis must not ask"); }
};

}  // namespace crackle::test
