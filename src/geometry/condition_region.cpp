// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/condition_region.h"

#include "common/failure.h"
#include "common/index.h"
#include "geometry/pre_crack.h"

#include "imprint.h"
#include "plate.h"
#include "regions.h"
#include "solid_body.h"
#include "tolerances.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

namespace crackle::geometry {

namespace {

using Interval = std::pair<double, double>;

double merging_distance(const Body& body) {
  return merging_share * std::ranges::max(body.size());
}

/// The own axes along which a patch has an extent.
std::array<std::size_t, 2> spanning_axes(const Patch& patch) {
  std::array<std::size_t, 2> axes{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < 3 && n < 2; ++i)
    if (patch.domain.upper[i] > patch.domain.lower[i]) axes[n++] = i;
  return axes;
}

/// The limits of a region along an own axis of a patch.
struct OwnInterval {
  Interval ends;
  bool is_line;  ///< the region has zero width
};

/// Empty if the limits exclude each other.
std::optional<OwnInterval> own_interval(const Patch& patch, std::size_t axis, const plane::Region& region,
                                        double near) {
  Interval interval = plane::unbounded;
  bool is_line = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const double slope = patch.axes[axis][i];
    if (slope == 0) continue;
    is_line = is_line || region[i].second - region[i].first <= near;
    double first = (region[i].first - patch.origin[i]) / slope;
    double last = (region[i].second - patch.origin[i]) / slope;
    if (first > last) std::swap(first, last);
    interval = {std::max(interval.first, first), std::min(interval.second, last)};
  }
  if (interval.first > interval.second + near) return {};
  return OwnInterval{interval, is_line};
}

/// True if a face normal to a coordinate axis lies within the region's limits along it.
bool is_at_region(const Patch& patch, const std::array<std::size_t, 2>& axes, const plane::Region& region,
                  double near) {
  const Point place = patch.at(patch.domain.lower);
  for (std::size_t i = 0; i < 3; ++i) {
    if (patch.axes[axes[0]][i] != 0 || patch.axes[axes[1]][i] != 0) continue;
    if (place[i] < region[i].first - near || place[i] > region[i].second + near) return false;
  }
  return true;
}

/// The part of an own interval that lies in a face, with its ends moved onto those of the face if close.
std::optional<Interval> clipped(const OwnInterval& wanted, const Interval& own, double near) {
  const auto [first, last] = wanted.ends;
  if (last < own.first - near || first > own.second + near) return {};
  const auto moved = [&](double end) {
    if (std::abs(end - own.first) <= near || end < own.first) return own.first;
    if (std::abs(end - own.second) <= near || end > own.second) return own.second;
    return end;
  };
  const Interval part{moved(first), moved(last)};
  if (wanted.is_line) return Interval{part.first, part.first};
  if (!(part.first < part.second)) return {};  // meets only the face's border
  return part;
}

/// The limits of a region that part a face; empty if the face lies outside them.
std::optional<plane::Region> limits_on(const Face& face, const std::array<std::size_t, 2>& axes,
                                       const plane::Region& region, double near) {
  Box bounds = nowhere;
  for (const auto& ends : face.rim) {
    Point own = face.patch.domain.lower;
    for (std::size_t k = 0; k < 2; ++k) own[axes[k]] = ends[0][k];
    bounds.include(face.patch.at(own));
  }
  plane::Region limits = plane::everywhere;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [first, last] = region[i];
    const bool is_line = last - first <= near;
    // An area does not just touch the region.
    const double least = is_line ? -near : near;
    if (bounds.upper[i] < first + least || bounds.lower[i] > last - least) return {};
    if (is_line || bounds.lower[i] < first - near) limits[i].first = first;
    if (is_line || bounds.upper[i] > last + near) limits[i].second = last;
  }
  return limits;
}

std::optional<FacePart> part_of(const Body& body, FaceId id, const plane::Region& region) {
  const Face& face = body.faces()[index(id)];
  const double near = merging_distance(body);
  FacePart part{id, face.patch, spanning_axes(face.patch), {}, {}, near};
  const bool is_aligned = std::ranges::all_of(std::array<std::size_t, 3>{0, 1, 2}, [&](std::size_t i) {
    return region[i] == plane::unbounded || face.patch.axes[part.axis[0]][i] == 0 ||
           face.patch.axes[part.axis[1]][i] == 0;
  });
  if (!is_aligned) {
    const auto limits = limits_on(face, part.axis, region, near);
    if (!limits) return {};
    part.limits = *limits;
    for (std::size_t k = 0; k < 2; ++k) {
      part.lower[k] = face.patch.domain.lower[part.axis[k]];
      part.upper[k] = face.patch.domain.upper[part.axis[k]];
    }
    return part;
  }
  if (!is_at_region(face.patch, part.axis, region, near)) return {};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::size_t axis = part.axis[k];
    const Interval own{face.patch.domain.lower[axis], face.patch.domain.upper[axis]};
    const auto wanted = own_interval(face.patch, axis, region, near);
    if (!wanted) return {};
    const auto interval = clipped(*wanted, own, near);
    if (!interval) return {};
    part.lower[k] = interval->first;
    part.upper[k] = interval->second;
  }
  return part;
}

Complex complex_of(const plane::Specimen& specimen) {
  return specimen.solid ? solid_complex(specimen.solid) : plate(specimen);
}

}  // namespace

int FacePart::n_dimensions() const {
  int n = (lower[0] < upper[0]) + (lower[1] < upper[1]);
  for (const auto& [first, last] : limits) n -= last - first <= tolerance;
  return std::max(n, 0);
}

bool FacePart::contains(const Point& p) const {
  for (std::size_t i = 0; i < 3; ++i)
    if (p[i] < limits[i].first - tolerance || p[i] > limits[i].second + tolerance) return false;
  const Point own = patch.own(p);
  for (std::size_t k = 0; k < 2; ++k)
    if (own[axis[k]] < lower[k] - tolerance || own[axis[k]] > upper[k] + tolerance) return false;
  return true;
}

const FacePart* ConditionRegion::on(FaceId face) const {
  const auto part = std::ranges::lower_bound(parts, face, {}, &FacePart::face);
  return part != parts.end() && part->face == face ? &*part : nullptr;
}

ConditionRegion condition_region(const Body& body, const input::Boundary& condition, std::size_t number) {
  ConditionRegion region;
  for (const FaceId id : body.faces_named(condition.on))
    if (auto part = part_of(body, id, condition.region)) region.parts.push_back(std::move(*part));
  if (region.parts.empty()) fail("boundary[{}]: its region contains no part of \"{}\"", number, condition.on);
  region.n_dimensions = std::ranges::max(region.parts, {}, &FacePart::n_dimensions).n_dimensions();
  std::erase_if(region.parts,
                [&](const FacePart& part) { return part.n_dimensions() < region.n_dimensions; });
  if (input::traits(condition.kind).by_area && region.n_dimensions < 2)
    fail("boundary[{}]: its region is a {}, which has no area for \"{}\"; give a force, or a wider region",
         number, region.n_dimensions == 1 ? "line" : "point", input::name_of(condition.kind));
  return region;
}

std::vector<ConditionRegion> condition_regions(const Body& body,
                                               std::span<const input::Boundary> conditions) {
  std::vector<ConditionRegion> regions;
  for (std::size_t i = 0; i < conditions.size(); ++i)
    regions.push_back(condition_region(body, conditions[i], i));
  return regions;
}

std::vector<ConditionRegion> touched_regions(const Body& body, std::span<const input::Tool> tools) {
  constexpr double parallel = 1e-9;
  const double near = merging_distance(body);
  std::vector<ConditionRegion> regions;
  for (const input::Tool& tool : tools) {
    const bool is_line = tool.shape == input::ToolShape::cylinder;
    if (!is_line && tool.shape != input::ToolShape::sphere) continue;
    ConditionRegion region;
    region.n_dimensions = is_line ? 1 : 0;
    for (std::size_t f = 0; f < body.faces().size(); ++f) {
      const Face& face = body.faces()[f];
      const double height = dot(tool.at - face.patch.at(face.patch.domain.lower), face.outward);
      if (std::abs(height - tool.radius) > near) continue;
      const Point foot = tool.at - height * face.outward;
      plane::Region limits = plane::everywhere;
      std::size_t n_limits = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        if (std::abs(std::abs(face.outward[i]) - 1) < parallel) continue;
        if (is_line && std::abs(std::abs(tool.axis[i]) - norm(tool.axis)) < parallel * norm(tool.axis))
          continue;
        limits[i] = {foot[i], foot[i]};
        ++n_limits;
      }
      // Other lines are not parallel to the axes of the face.
      if (n_limits != (is_line ? 1 : 2)) continue;
      if (auto part = part_of(body, static_cast<FaceId>(f), limits)) region.parts.push_back(std::move(*part));
    }
    if (!region.parts.empty()) regions.push_back(std::move(region));
  }
  return regions;
}

std::unique_ptr<const Body> make_body(const plane::Specimen& specimen) {
  return std::make_unique<Body>(complex_of(specimen));
}

std::unique_ptr<const Body> make_composite_body(const input::Model& model) {
  Complex complex = complex_of(model.specimen);
  add_pre_cracks(complex, model);
  if (!model.specimen.regions.empty()) divide(complex, model.specimen, model.interface_pairs());
  return std::make_unique<Body>(std::move(complex));
}

std::unique_ptr<const Body> make_body(const input::Model& model) {
  auto plain = make_composite_body(model);
  auto regions = condition_regions(*plain, model.boundaries);
  std::ranges::move(touched_regions(*plain, model.tools), std::back_inserter(regions));
  if (!has_borders(*plain, regions)) return plain;
  return std::make_unique<Body>(imprint(*plain, regions));
}

std::vector<RegionRefinement> region_refinements(const input::Model& model) {
  std::map<int, double> finest;
  for (const SpacingSource& source : make_body(model)->spacing_sources(model.mesh)) {
    if (source.condition < 0 || index(source.condition) >= model.boundaries.size()) continue;
    const auto [entry, is_new] = finest.emplace(source.condition, source.spacing);
    entry->second = std::min(entry->second, source.spacing);
  }
  std::vector<RegionRefinement> result;
  for (const auto& [condition, spacing] : finest) result.push_back({index(condition), spacing});
  return result;
}

std::size_t n_crack_starts(const input::Model& model) {
  const plane::Specimen& specimen = model.specimen;
  const std::size_t n = specimen.notches.size() + specimen.cracks.size() + (model.flaws.empty() ? 0 : 1);
  return plane::is_box(specimen) || specimen.solid ? n : n + specimen.holes.size() + 1;
}

}  // namespace crackle::geometry
