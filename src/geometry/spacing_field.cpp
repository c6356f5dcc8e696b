// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/mesh_regions.h"
#include "crackle/geometry/mother_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace crackle::geometry {

SpacingField::SpacingField(const Body& body, const input::Mesh& mesh) {
  const Point size = body.size();
  far_ = std::min(mesh.spacing, *std::ranges::min_element(size));
  for (std::size_t i = 0; i < mesh.regions.size(); ++i)
    sources_.push_back({box_of(mesh.regions[i], body.bounds()), mesh.regions[i].spacing, mesh.growth,
                        fmt::format("mesh.region[{}]", i)});
  for (SpacingSource& source : body.spacing_sources(mesh)) sources_.push_back(std::move(source));
  std::erase_if(sources_, [&](const SpacingSource& source) { return !(source.spacing < far_); });
}

double SpacingField::operator()(const Point& p) const {
  double spacing = far_;
  for (const SpacingSource& source : sources_)
    spacing = std::min(spacing, source.spacing + source.growth * distance(p, source.region));
  return spacing;
}

double SpacingField::lower_bound(const Box& region) const {
  double spacing = far_;
  for (const SpacingSource& source : sources_)
    spacing = std::min(spacing, source.spacing + source.growth * distance(region, source.region));
  return spacing;
}

double SpacingField::upper_bound(const Box& region) const {
  double spacing = far_;
  for (const SpacingSource& source : sources_) {
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
  for (const SpacingSource& source : sources_) growth = std::max(growth, source.growth);
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
