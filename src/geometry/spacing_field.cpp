// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/common/index.h"
#include "crackle/geometry/mesh_regions.h"
#include "crackle/geometry/mother_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace crackle::geometry {

namespace {

/// Growth away from places where the shape of the body, not the input, asks for a fine spacing.
constexpr double shape_growth = 0.2;

/// The box of the points between two boxes: along each axis their common interval or the gap between them.
Box between(const Box& a, const Box& b) {
  Box region{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double inner_lower = std::max(a.lower[i], b.lower[i]);
    const double inner_upper = std::min(a.upper[i], b.upper[i]);
    region.lower[i] = std::min(inner_lower, inner_upper);
    region.upper[i] = std::max(inner_lower, inner_upper);
  }
  return region;
}

}  // namespace

SpacingField::SpacingField(const Body& body, const input::Mesh& mesh) {
  far_ = std::min(mesh.spacing, *std::min_element(body.size().begin(), body.size().end()));
  const double growth = std::max(mesh.growth, shape_growth);
  const auto add = [&](const Box& region, double spacing, double rate, std::string reason) {
    if (spacing < far_) sources_.push_back({region, spacing, rate, std::move(reason)});
  };
  for (std::size_t i = 0; i < mesh.regions.size(); ++i)
    add(box_of(mesh.regions[i], body.size()), mesh.regions[i].spacing, mesh.growth,
        fmt::format("mesh.region[{}]", i));
  for (int i = 0; i < body.n_notches(); ++i) {
    const Box& slot = body.slot(i);
    add(body.surfaces()[index(8 + 3 * i)].extent, mesh.notch_spacing, mesh.growth,
        fmt::format("notch_spacing at notch {}", i + 1));
    const bool shallow = body.notch(i).depth < body.notch(i).height;
    add(slot, std::min(body.notch(i).height, body.notch(i).depth), growth,
        fmt::format("the {} of notch {}", shallow ? "depth" : "height", i + 1));
    for (int j = 0; j < i; ++j) {
      const double gap = distance(slot, body.slot(j));
      add(between(slot, body.slot(j)), gap, growth,
          fmt::format("the distance of notches {} and {}", j + 1, i + 1));
    }
    for (std::size_t id = 2; id < 6; ++id) {
      const Box& face = body.surfaces()[id].extent;
      const double gap = distance(slot, face);
      if (gap > 0)
        add(between(slot, face), gap, growth, fmt::format("the distance of notch {} from a face", i + 1));
    }
  }
}

double SpacingField::operator()(const Point& p) const {
  double spacing = far_;
  for (const Source& source : sources_)
    spacing = std::min(spacing, source.spacing + source.growth * distance(p, source.region));
  return spacing;
}

double SpacingField::lower_bound(const Box& region) const {
  double spacing = far_;
  for (const Source& source : sources_)
    spacing = std::min(spacing, source.spacing + source.growth * distance(region, source.region));
  return spacing;
}

double SpacingField::upper_bound(const Box& region) const {
  double spacing = far_;
  for (const Source& source : sources_) {
    // The distance of the corner that is farthest from the source.
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double gap =
          std::max({source.region.lower[i] - region.lower[i], region.upper[i] - source.region.upper[i], 0.0});
      sum += gap * gap;
    }
    spacing = std::min(spacing, source.spacing + source.growth * std::sqrt(sum));
  }
  return spacing;
}

double SpacingField::largest_growth() const {
  double growth = 0;
  for (const Source& source : sources_) growth = std::max(growth, source.growth);
  return growth;
}

std::string SpacingField::range_text() const {
  const auto finest = std::min_element(sources_.begin(), sources_.end(),
                                       [](const auto& a, const auto& b) { return a.spacing < b.spacing; });
  if (finest == sources_.end()) return fmt::format("the spacing is {:.3g} mm", far_ * 1e3);
  return fmt::format("the spacing is {:.3g} mm at its finest ({}) and {:.3g} mm at its coarsest",
                     finest->spacing * 1e3, finest->reason, far_ * 1e3);
}

}  // namespace crackle::geometry
