// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/mesh_regions.h"
#include "geometry/mother_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace crackle::geometry {

double SpacingSource::at(const Point& p) const {
  return spacing +
         growth * (wall ? plane::distance({p[1], p[2]}, (*wall)[0], (*wall)[1]) : distance(p, region));
}

namespace {

/// Bounds on the distance between a box and a wall, by the circle around the box; not sharp.
std::pair<double, double> distances(const Box& box, const std::array<plane::Point, 2>& wall) {
  const plane::Point middle{(box.lower[1] + box.upper[1]) / 2, (box.lower[2] + box.upper[2]) / 2};
  const double radius = plane::norm({box.upper[1] - middle[0], box.upper[2] - middle[1]});
  const double gap = plane::distance(middle, wall[0], wall[1]);
  return {std::max(0.0, gap - radius), gap + radius};
}

}  // namespace

double SpacingSource::lower_bound(const Box& part) const {
  return spacing + growth * (wall ? distances(part, *wall).first : distance(part, region));
}

double SpacingSource::upper_bound(const Box& part) const {
  if (wall) return spacing + growth * distances(part, *wall).second;
  // Distance of the corner farthest from the source.
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double gap = std::max({region.lower[i] - part.lower[i], part.upper[i] - region.upper[i], 0.0});
    sum += gap * gap;
  }
  return spacing + growth * std::sqrt(sum);
}

std::vector<SpacingSource> region_sources(const input::Mesh& mesh, const Box& bounds) {
  std::vector<SpacingSource> sources;
  for (std::size_t i = 0; i < mesh.regions.size(); ++i)
    sources.push_back({box_of(mesh.regions[i], bounds), mesh.regions[i].spacing, mesh.growth,
                       fmt::format("mesh.region[{}]", i)});
  return sources;
}

SpacingField::SpacingField(const Body& body, const input::Mesh& mesh)
    : SpacingField(body.bounds(), mesh, body.spacing_sources(mesh)) {}

SpacingField::SpacingField(const Box& bounds, const input::Mesh& mesh,
                           const std::vector<SpacingSource>& sources)
    : far_(std::min(mesh.spacing, std::ranges::min(bounds.upper - bounds.lower))),
      sources_(region_sources(mesh, bounds)) {
  sources_.insert(sources_.end(), sources.begin(), sources.end());
  std::erase_if(sources_, [&](const SpacingSource& source) { return !(source.spacing < far_); });
}

double SpacingField::operator()(const Point& p) const {
  double spacing = far_;
  for (const SpacingSource& source : sources_) {
    // A bound without a square root, which nearly all sources fail.
    double gap = 0;
    for (std::size_t i = 0; i < 3; ++i)
      gap = std::max({gap, source.region.lower[i] - p[i], p[i] - source.region.upper[i]});
    if (source.spacing + source.growth * gap < spacing) spacing = std::min(spacing, source.at(p));
  }
  return spacing;
}

double SpacingField::lower_bound(const Box& region) const {
  double spacing = far_;
  for (const SpacingSource& source : sources_) spacing = std::min(spacing, source.lower_bound(region));
  return spacing;
}

double SpacingField::upper_bound(const Box& region) const {
  double spacing = far_;
  for (const SpacingSource& source : sources_) spacing = std::min(spacing, source.upper_bound(region));
  return spacing;
}

double SpacingField::largest_growth() const {
  double growth = 0;
  for (const SpacingSource& source : sources_) growth = std::max(growth, source.growth);
  return growth;
}

const SpacingSource* SpacingField::finest() const {
  return sources_.empty() ? nullptr : &*std::ranges::min_element(sources_, {}, &SpacingSource::spacing);
}

std::string SpacingField::range_text() const {
  const SpacingSource* const least = finest();
  if (!least) return fmt::format("the spacing is {:.3g} mm", far_ * 1e3);
  return fmt::format("the spacing is {:.3g} mm at its finest ({}) and {:.3g} mm at its coarsest",
                     least->spacing * 1e3, least->reason, far_ * 1e3);
}

}  // namespace crackle::geometry
