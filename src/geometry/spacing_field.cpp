// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/index.h"
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

constexpr std::size_t many_sources = 64;
constexpr std::size_t n_cells = 24;  ///< of the grid, along each axis

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
  if (sources_.size() > many_sources) make_grid(bounds);
}

void SpacingField::make_grid(const Box& bounds) {
  bounds_ = bounds;
  of_cell_.resize(n_cells * n_cells * n_cells);
  const Vector step = (bounds.upper - bounds.lower) / static_cast<double>(n_cells);
  std::vector<double> least(sources_.size());
  for (std::size_t cell = 0; cell < of_cell_.size(); ++cell) {
    const std::array<std::size_t, 3> number{cell % n_cells, cell / n_cells % n_cells,
                                            cell / n_cells / n_cells};
    Box box{};
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = bounds.lower[i] + static_cast<double>(number[i]) * step[i];
      box.upper[i] = box.lower[i] + step[i];
    }
    double most = far_;
    for (std::size_t s = 0; s < sources_.size(); ++s) {
      least[s] = sources_[s].lower_bound(box);
      if (least[s] < most) most = std::min(most, sources_[s].upper_bound(box));
    }
    for (std::size_t s = 0; s < sources_.size(); ++s)
      if (least[s] <= most * (1 + 1e-9)) of_cell_[cell].push_back(static_cast<std::int32_t>(s));
  }
}

double SpacingField::operator()(const Point& p) const {
  double spacing = far_;
  const auto look_at = [&](const SpacingSource& source) {
    // A bound without a square root, which nearly all sources fail.
    double gap = 0;
    for (std::size_t i = 0; i < 3; ++i)
      gap = std::max({gap, source.region.lower[i] - p[i], p[i] - source.region.upper[i]});
    if (source.spacing + source.growth * gap < spacing) spacing = std::min(spacing, source.at(p));
  };
  if (of_cell_.empty() || !bounds_.contains(p)) {
    std::ranges::for_each(sources_, look_at);
    return spacing;
  }
  std::size_t cell = 0;
  for (std::size_t i = 3; i-- > 0;) {
    const double share = (p[i] - bounds_.lower[i]) / (bounds_.upper[i] - bounds_.lower[i]);
    cell = cell * n_cells + std::min(static_cast<std::size_t>(share * n_cells), n_cells - 1);
  }
  for (const std::int32_t source : of_cell_[cell]) look_at(sources_[index(source)]);
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
